/* What the two processes say to each other, the motion, and how a process asks for real time. */
#include <errno.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

#define LOAD_ANGLE 0.3 /* [rad] */
#define RISE 0.2       /* [s] */
#define DWELL 0.1      /* [s] */

typedef struct {
    int64_t sample;
    double y[CD_READINGS];
} reading_message;

typedef struct {
    int64_t sample;
    double u;
} command_message;

/* Real-time scheduling and memory that is not swapped, where the system allows them; says so on a stream. */
static void start_real_time(FILE *report)
{
    const struct sched_param priority = {.sched_priority = 50};
    const char *why = sched_setscheduler(0, SCHED_FIFO, &priority) == 0 ? "yes" : strerror(errno);
    const char *locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? "yes" : strerror(errno);
    if (report != NULL) {
        fprintf(report, "SCHED_FIFO: %s; memory locked: %s\n", why, locked);
    }
}

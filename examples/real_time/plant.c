/* The exported plant in real time: wakes at every sample, sends the readings, steps with the command that came in time.
 *
 * usage: plant SECONDS CONTROLLER; a command that is not there at the next sample is late: the last one is held.
 */
#define _GNU_SOURCE
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "cabledrive_plant.h"
#include "messages.h"

#define BINS 12 /* powers of two of microseconds */

typedef struct {
    long bin[BINS];
    double largest;
} histogram;

static void count(histogram *h, double seconds)
{
    const double micro = 1e6 * seconds;
    int bin = 0;
    while (bin < BINS - 1 && micro >= (double)(1L << bin)) {
        ++bin;
    }
    ++h->bin[bin];
    h->largest = micro > h->largest ? micro : h->largest;
}

static void show(const char *name, const histogram *h)
{
    printf("%s, largest %.0f us:\n", name, h->largest);
    for (int i = 0; i < BINS; ++i) {
        if (h->bin[i] > 0) {
            printf(i < BINS - 1 ? "  below %5ld us: %ld\n" : "  from  %5ld us: %ld\n", 1L << (i < BINS - 1 ? i : i - 1),
                   h->bin[i]);
        }
    }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void sleep_until(double time)
{
    const struct timespec t = {(time_t)time, (long)(1e9 * (time - floor(time)))};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) {
    }
}

/* The command of a sample, if it comes before a time; 1 where it came. */
static int answered(int socket, int64_t sample, double before, command_message *in)
{
    for (;;) {
        const double left = before - now();
        const struct timespec wait = {0, left > 0.0 ? (long)(1e9 * left) : 0};
        struct pollfd one = {socket, POLLIN, 0};
        if (ppoll(&one, 1, &wait, NULL) <= 0) {
            return 0;
        }
        if (read(socket, in, sizeof *in) != (ssize_t)sizeof *in) {
            return 0;
        }
        if (in->sample == sample) { /* an older one comes too late */
            return 1;
        }
    }
}

int main(int words, char *word[])
{
    const long samples = words > 2 ? lround(atof(word[1]) / CD_SAMPLE_TIME) : 0;
    static cd_plant plant;
    static histogram jitter, reply;
    int ends[2];
    double u = 0.0, moved = 0.0;
    long late = 0;
    if (samples < 1 || socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends) != 0) {
        fputs("usage: plant SECONDS CONTROLLER\n", stderr);
        return 2;
    }
    const pid_t child = fork();
    if (child == 0) {
        char name[16];
        close(ends[0]);
        snprintf(name, sizeof name, "%d", ends[1]);
        execl(word[2], word[2], name, (char *)NULL);
        _exit(2);
    }
    close(ends[1]);
    start_real_time(stdout);
    cd_plant_init(&plant);
    const double start = now() + 0.05;
    for (int64_t k = 0; k < samples; ++k) {
        reading_message out = {.sample = k};
        command_message in = {.sample = -1};
        const double due = start + (double)k * CD_SAMPLE_TIME;
        sleep_until(due);
        const double woke = now();
        count(&jitter, woke - due);
        cd_plant_read(&plant, out.y);
        if (write(ends[0], &out, sizeof out) != (ssize_t)sizeof out) {
            return 1;
        }
        if (answered(ends[0], k, due + CD_SAMPLE_TIME, &in)) {
            u = in.u;
            count(&reply, now() - woke);
        } else {
            ++late;
        }
        cd_plant_step(&plant, u, 0.0, 0.0);
        moved = fmax(moved, fabs(cd_plant_angle(&plant, CD_SHAFTS - 1)));
    }
    close(ends[0]);
    waitpid(child, NULL, 0);
    show("wake-up behind the sample's time", &jitter);
    show("reply of the controller", &reply);
    printf("samples %ld, deadlines missed %ld, largest load angle %.17g rad at the first shaft\n", samples, late, moved);
    return 0;
}

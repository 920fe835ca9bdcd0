/* The exported controller as a process of its own: readings come in by a socket, commands go out. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <unistd.h>

#include "cabledrive_law.h"
#include "messages.h"

int main(int count, char *words[])
{
    const int socket = count > 1 ? atoi(words[1]) : 0;
    static cd_law law;
    static cd_reference path;
    reading_message in;
    command_message out = {0, 0.0};
    real ref[CD_REFERENCES];
    start_real_time(NULL);
    for (int begun = 0; read(socket, &in, sizeof in) == (ssize_t)sizeof in; begun = 1) {
        if (!begun) {
            cd_init(&law, in.y);
            cd_reference_init(&path, LOAD_ANGLE, RISE, DWELL, 1000);
        }
        cd_reference_row(&path, (real)in.sample * CD_SAMPLE_TIME, ref);
        cd_step(&law, in.y, ref, &out.u);
        out.sample = in.sample;
        if (write(socket, &out, sizeof out) != (ssize_t)sizeof out) {
            return 1;
        }
    }
    return 0;
}

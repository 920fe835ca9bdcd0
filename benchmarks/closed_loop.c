/* A sampled adaptive robust law of Model 4 on Model 4 with smoothed friction, as one would write it in C: states,
   estimates, one exact transition per sample with friction on a straight line in it. */
#include <math.h>

enum { N = 3, N2 = 6, M = 7, WIDE = 11, REFERENCE = 9 };

void closed_loop(long samples, const double *restrict to_flat, const double *restrict rows,
                 const double *restrict learning, const double *restrict scalars,
                 const double *restrict reference, const double *restrict target, const double *restrict move,
                 const double *restrict plant, double limit, double *restrict x, double *restrict p,
                 double *restrict score)
{
    for (long k = 0; k < samples; k++) {
        const double *wanted = reference + REFERENCE * k;
        double sigma = 0.0, z_eq = wanted[N2], u = 0.0, q = 0.0;
        for (int i = 0; i < N2; i++) {
            double z = 0.0;
            for (int j = 0; j < N2; j++)
                z += to_flat[N2 * i + j] * x[j];
            double e = z - wanted[i];
            sigma += rows[i] * e;
            if (i > 0)
                z_eq -= rows[i - 1] * e;
            u += rows[N2 + 1 + i] * z;
            q += rows[2 * (N2 + 1) + i] * z;
        }
        q += rows[2 * (N2 + 1) + N2] * z_eq;
        double phi[4] = {-q, -x[N], -tanh(scalars[2] * x[N]), 1.0};
        for (int i = 0; i < 4; i++) {
            u -= phi[i] * p[i];
            double fresh = p[i] + scalars[0] * learning[12 + i] * phi[i] * sigma;
            p[i] = fmin(fmax(fresh, learning[4 + i]), learning[8 + i]);
        }
        u -= scalars[1] * sigma;
        u = fmin(fmax(u, -limit), limit);
        double error = fabs(x[N - 1] - target[k]);
        score[0] = fmax(score[0], error);
        score[1] += error * error;
        score[2] = fmax(score[2], fabs(u));
        double before = plant[0] * tanh(plant[2] * x[N]), fresh[M];
        for (int i = 0; i < M; i++) {
            const double *row = move + WIDE * i;
            double value = row[M] * u + row[M + 1] * (plant[1] - before);
            for (int j = 0; j < M; j++)
                value += row[j] * x[j];
            fresh[i] = value;
        }
        double rise = before - plant[0] * tanh(plant[2] * fresh[N]);
        for (int i = 0; i < M; i++)
            x[i] = fresh[i] + move[WIDE * i + M + 3] * rise;
    }
}

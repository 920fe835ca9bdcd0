/* The default chain as one would write it in C: equal segments, exact law, leapfrog, no audit.
   u, v, w and their velocities have 2 n + 1 entries, the last one node 0 again; p has 2 n entries each. */
#include <math.h>

void integrate(long steps, long n, double h, double dt, double pretension, double rigidity, double mass,
           double damping, double gravity, double drive_mass, double load_mass, double push, double omega,
           double *restrict u, double *restrict v, double *restrict w,
           double *restrict u_t, double *restrict v_t, double *restrict w_t,
           double *restrict p_u, double *restrict p_v, double *restrict p_w)
{
    const long last = 2 * n;
    const double stiffness = rigidity + pretension, per_h = 1.0 / h, damped = 0.5 * dt * damping;
    const double keep = (1.0 - damped) / (1.0 + damped), kick = dt / mass / (1.0 + damped);
    const double kick_u = dt / mass, fall = gravity * dt / (1.0 + damped);
    for (long j = 0; j < steps; j++) {
#pragma GCC ivdep
        for (long i = 0; i < last; i++) {
            double u_x = (u[i + 1] - u[i]) * per_h, v_x = (v[i + 1] - v[i]) * per_h;
            double w_x = (w[i + 1] - w[i]) * per_h;
            double stretch = sqrt((1.0 + u_x) * (1.0 + u_x) + v_x * v_x + w_x * w_x);
            double pull = (pretension + stiffness * (stretch - 1.0)) / stretch;
            p_u[i] = pull * (1.0 + u_x) - pretension;
            p_v[i] = pull * v_x;
            p_w[i] = pull * w_x;
        }
        double on_drive = p_u[0] - p_u[last - 1] + push * sin(omega * j * dt);
        double drive = u_t[0] + dt * on_drive / drive_mass;
        double load = u_t[n] + dt * (p_u[n] - p_u[n - 1]) / load_mass, load_place = u[n] + dt * load;
#pragma GCC ivdep
        for (long i = 1; i < last; i++) {
            double speed = u_t[i] + kick_u * (p_u[i] - p_u[i - 1]);
            u_t[i] = speed;
            u[i] += dt * speed;
        }
#pragma GCC ivdep
        for (long i = 1; i < last; i++) {
            double speed = keep * v_t[i] + kick * (p_v[i] - p_v[i - 1]);
            v_t[i] = speed;
            v[i] += dt * speed;
        }
#pragma GCC ivdep
        for (long i = 1; i < n; i++) {
            double speed = keep * w_t[i] + kick * (p_w[i] - p_w[i - 1]) - fall;
            w_t[i] = speed;
            w[i] += dt * speed;
        }
#pragma GCC ivdep
        for (long i = n + 1; i < last; i++) {
            double speed = keep * w_t[i] + kick * (p_w[i] - p_w[i - 1]) + fall;
            w_t[i] = speed;
            w[i] += dt * speed;
        }
        u_t[0] = u_t[last] = drive;
        u_t[n] = load;
        u[0] += dt * drive;
        u[n] = load_place;
        u[last] = u[0];
        v[n] = v_t[n] = 0.0;
    }
}

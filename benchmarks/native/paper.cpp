// Monte Carlo of the paper's robot, written by hand: samples side by side in vector registers,
// Dormand-Prince 8, tangents in the leg's own wrench, elimination down to four unknowns.
//
// The motors are held. Unknown are n_1(0), m_1(0), m_2(0); n_2 = f_P - n_1, and p_P is the pivot
// of the first leg. The other rows of (15) are left: no moment at both pivots, pivots that meet.

#include <cmath>
#include <thread>
#include <vector>

#include "tableau.h"  // constexpr double A[12][12], B[12], made from scipy's DOP853

namespace {

constexpr int W = 8;  // samples in one block
using Lanes = double[W];

#define EACH _Pragma("omp simd") for (int w = 0; w < W; ++w)

struct Robot {
    double length, before, after, distance, force[2];
};

// A rod's position and direction, then for each of (n_y, n_z, m) the tangents of its position
// and of its angle. The moment follows from the moment balance.
constexpr int STATES = 13;

struct Tip {
    Lanes pivot[2], moment;
    Lanes pivot_by[2][3], moment_by[3];
};

void rates(const Lanes* x, const Lanes& compliance, const Lanes& rest, const Lanes* n,
           const Lanes& m_0, Lanes* out) {
    EACH {
        const double y = x[0][w], z = x[1][w], c = x[2][w], s = x[3][w];
        const double m = m_0[w] - (y * n[1][w] - z * n[0][w]);
        const double u = compliance[w] * m + rest[w];
        out[0][w] = c;
        out[1][w] = s;
        out[2][w] = -s * u;
        out[3][w] = c * u;
        for (int k = 0; k < 3; ++k) {
            const double dy = x[4 + k][w], dz = x[7 + k][w], turn = x[10 + k][w];
            double dm = -(dy * n[1][w] - dz * n[0][w]);
            dm += k == 0 ? z : (k == 1 ? -y : 1.0);
            out[4 + k][w] = -s * turn;
            out[7 + k][w] = c * turn;
            out[10 + k][w] = compliance[w] * dm;
        }
    }
}

void integrate(const Robot& robot, double motor, double q, const Lanes& compliance,
               const Lanes& rest, const Lanes* n, const Lanes& m_0, int steps, Tip& tip) {
    // Around the rod's base, in world axes.
    const double c_0 = std::cos(q), s_0 = std::sin(q), h = robot.length / steps;
    Lanes x[STATES], stage[STATES], slope[12][STATES];
    for (int i = 0; i < STATES; ++i) EACH x[i][w] = 0.0;
    EACH {
        x[2][w] = c_0;
        x[3][w] = s_0;
    }
    for (int step = 0; step < steps; ++step) {
        rates(x, compliance, rest, n, m_0, slope[0]);
        for (int j = 1; j < 12; ++j) {
            for (int i = 0; i < STATES; ++i) {
                Lanes sum = {};
                for (int k = 0; k < j; ++k)
                    if (A[j][k] != 0.0) EACH sum[w] += A[j][k] * slope[k][i][w];
                EACH stage[i][w] = x[i][w] + h * sum[w];
            }
            rates(stage, compliance, rest, n, m_0, slope[j]);
        }
        for (int i = 0; i < STATES; ++i) {
            Lanes sum = {};
            for (int k = 0; k < 12; ++k)
                if (B[k] != 0.0) EACH sum[w] += B[k] * slope[k][i][w];
            EACH x[i][w] += h * sum[w];
        }
    }
    const double b = robot.after;
    EACH {
        const double c = x[2][w], s = x[3][w];
        const double reach[2] = {x[0][w] + b * c, x[1][w] + b * s};
        tip.pivot[0][w] = motor + robot.before * c_0 + reach[0];
        tip.pivot[1][w] = robot.before * s_0 + reach[1];
        tip.moment[w] = m_0[w] - (reach[0] * n[1][w] - reach[1] * n[0][w]);
        for (int k = 0; k < 3; ++k) {
            const double turn = x[10 + k][w];
            const double dy = x[4 + k][w] - b * s * turn, dz = x[7 + k][w] + b * c * turn;
            tip.pivot_by[0][k][w] = dy;
            tip.pivot_by[1][k][w] = dz;
            double dm = -(dy * n[1][w] - dz * n[0][w]);
            dm += k == 0 ? reach[1] : (k == 1 ? -reach[0] : 1.0);
            tip.moment_by[k][w] = dm;
        }
    }
}

// One Newton iteration; returns the largest change of an unknown relative to its scale.
double iterate(const Robot& robot, const double* q, const Lanes* rho, Lanes* n, Lanes& m_1,
               Lanes& m_2, int steps, Tip& first) {
    Lanes n_2[2], compliance[2], rest[2];
    EACH {
        for (int i = 0; i < 2; ++i) {
            n_2[i][w] = robot.force[i] - n[i][w];
            compliance[i][w] = 1.0 / rho[2 * i][w];
            rest[i][w] = 1.0 / rho[2 * i + 1][w];
        }
    }
    Tip second;
    integrate(robot, -0.5 * robot.distance, q[0], compliance[0], rest[0], n, m_1, steps, first);
    integrate(robot, 0.5 * robot.distance, q[1], compliance[1], rest[1], n_2, m_2, steps, second);
    Lanes largest;
    EACH {
        // m_1 and m_2 from the rows of the moments, n_1 from the 2 x 2 system that is left.
        const double a = 1.0 / first.moment_by[2][w], d = 1.0 / second.moment_by[2][w];
        double J[2][2], r[2];
        for (int i = 0; i < 2; ++i) {
            const double by_1 = first.pivot_by[i][2][w] * a, by_2 = second.pivot_by[i][2][w] * d;
            for (int k = 0; k < 2; ++k)
                J[i][k] = first.pivot_by[i][k][w] - by_1 * first.moment_by[k][w] +
                          second.pivot_by[i][k][w] - by_2 * second.moment_by[k][w];
            r[i] = -(first.pivot[i][w] - second.pivot[i][w] - by_1 * first.moment[w] +
                     by_2 * second.moment[w]);
        }
        const double det = 1.0 / (J[0][0] * J[1][1] - J[0][1] * J[1][0]);
        const double dn[2] = {det * (J[1][1] * r[0] - J[0][1] * r[1]),
                              det * (J[0][0] * r[1] - J[1][0] * r[0])};
        const double dm_1 = -a * (first.moment[w] + first.moment_by[0][w] * dn[0] +
                                  first.moment_by[1][w] * dn[1]);
        const double dm_2 = -d * (second.moment[w] - second.moment_by[0][w] * dn[0] -
                                  second.moment_by[1][w] * dn[1]);
        n[0][w] += dn[0];
        n[1][w] += dn[1];
        m_1[w] += dm_1;
        m_2[w] += dm_2;
        // Where the pivot is after the step, to first order.
        for (int i = 0; i < 2; ++i)
            first.pivot[i][w] += first.pivot_by[i][0][w] * dn[0] +
                                 first.pivot_by[i][1][w] * dn[1] + first.pivot_by[i][2][w] * dm_1;
        largest[w] = std::fmax(std::fabs(dn[0]), std::fabs(dn[1]));
    }
    double worst = 0.0;
    for (int w = 0; w < W; ++w) worst = std::fmax(worst, largest[w]);
    return worst;
}

void solve_part(const Robot& robot, const double* q, const double* nominal, const double* slope,
                const double* centre, const double* rho, double* ends, long begin, long end,
                int steps, int iterations) {
    for (long block = begin; block < end; block += W) {
        Lanes parameters[4], n[2], m_1, m_2;
        EACH {
            const long sample = block + w < end ? block + w : end - 1;
            double start[4];
            for (int i = 0; i < 4; ++i) start[i] = nominal[i];
            for (int j = 0; j < 4; ++j) {
                parameters[j][w] = rho[4 * sample + j];
                const double away = parameters[j][w] - centre[j];
                for (int i = 0; i < 4; ++i) start[i] += slope[4 * i + j] * away;
            }
            n[0][w] = start[0];
            n[1][w] = start[1];
            m_1[w] = start[2];
            m_2[w] = start[3];
        }
        Tip tip;
        for (int k = 0; k < iterations; ++k)
            iterate(robot, q, parameters, n, m_1, m_2, steps, tip);
        for (int w = 0; w < W && block + w < end; ++w)
            for (int i = 0; i < 2; ++i) ends[2 * (block + w) + i] = tip.pivot[i][w];
    }
}

}  // namespace

// `nominal` and the rows of `slope` are (n_1y, n_1z, m_1, m_2); `ends` receives p_P.
extern "C" void solve(const double* robot, const double* q, const double* nominal,
                      const double* slope, const double* centre, const double* rho, double* ends,
                      long samples, int steps, int iterations, int threads) {
    const Robot described = {robot[0], robot[1], robot[2], robot[3], {robot[4], robot[5]}};
    std::vector<std::thread> crew;
    const long share = (samples / threads + W - 1) / W * W;
    for (int t = 0; t < threads; ++t) {
        const long begin = t * share, end = t + 1 == threads ? samples : begin + share;
        crew.emplace_back([=] {
            solve_part(described, q, nominal, slope, centre, rho, ends, begin, end, steps,
                       iterations);
        });
    }
    for (auto& one : crew) one.join();
}

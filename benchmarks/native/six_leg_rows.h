// Unknowns and equations of the six-leg robot, and their differences leg by leg.

#include "six_rods.h"

constexpr double SHIFT = 1e-8;  // of a difference quotient, N and N·m

struct Pose {
    double p[3], R[3][3];
};

// `own[i]` is (n, m_x, m_y)(0) of a leg.
struct Unknowns {
    double own[LEGS][OWN], length[LEGS];
};

// Rows of a leg: its tip's position, two components of its tangent in the axes of the platform,
// then what it leaves of the balance of forces and of moments about the platform's point.
constexpr int ROWS = OWN + 6;

struct Rows {
    double leg[LEGS][OWN], balance[6];
};

// by[leg][k]: derivative of the leg's rows in its k-th own unknown, the last in its length.
using Slopes = double[LEGS][OWN + 1][ROWS];

inline void arm_of(const Robot& robot, const Pose& pose, int leg, double* arm) {
    for (int i = 0; i < 3; ++i) arm[i] = dot(pose.R[i], robot.hole[leg]);
}

// The rod's part of a leg's rows, from a tip or from the derivative of one.
inline void rows_of(const Pose& pose, const double* arm, const double* p, const double* t,
                    const double* n, const double* m, double* out) {
    double lever[3];
    cross(arm, n, lever);
    for (int i = 0; i < 3; ++i) {
        out[i] = p[i];
        out[OWN + i] = -n[i];
        out[OWN + 3 + i] = -(m[i] + lever[i]);
    }
    for (int i = 0; i < 2; ++i)
        out[3 + i] = pose.R[0][i] * t[0] + pose.R[1][i] * t[1] + pose.R[2][i] * t[2];
}

inline void residual(const Robot& robot, const Pose& pose, const Tip<double> (&tips)[LEGS],
                     Rows& f) {
    for (int i = 0; i < 6; ++i) f.balance[i] = i == 2 ? -robot.load : 0.0;
    for (int leg = 0; leg < LEGS; ++leg) {
        const Tip<double>& tip = tips[leg];
        double arm[3], rows[ROWS];
        arm_of(robot, pose, leg, arm);
        rows_of(pose, arm, tip.p, tip.t, tip.n, tip.m, rows);
        for (int i = 0; i < 3; ++i) rows[i] -= pose.p[i] + arm[i];
        for (int i = 0; i < OWN; ++i) f.leg[leg][i] = rows[i];
        for (int i = 0; i < 6; ++i) f.balance[i] += rows[OWN + i];
    }
}

// From tips, and from those with one unknown shifted. The length needs no other integration.
inline void slopes(const Robot& robot, const Pose& pose, const Tip<double> (&tips)[LEGS],
                   const Tip<double> (&shifted)[LEGS][OWN], Slopes& by) {
    const double up[3] = {0.0, 0.0, robot.weight};
    for (int leg = 0; leg < LEGS; ++leg) {
        const Tip<double>& tip = tips[leg];
        double arm[3];
        arm_of(robot, pose, leg, arm);
        for (int k = 0; k < OWN; ++k) {
            const Tip<double>& other = shifted[leg][k];
            double d[4][3];
            for (int i = 0; i < 3; ++i) {
                d[0][i] = (other.p[i] - tip.p[i]) / SHIFT;
                d[1][i] = (other.t[i] - tip.t[i]) / SHIFT;
                d[2][i] = (other.n[i] - tip.n[i]) / SHIFT;
                d[3][i] = (other.m[i] - tip.m[i]) / SHIFT;
            }
            rows_of(pose, arm, d[0], d[1], d[2], d[3], by[leg][k]);
        }
        rows_of(pose, arm, tip.dp, tip.dt, up, tip.dm, by[leg][OWN]);
    }
}

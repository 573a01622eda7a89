// The published algorithm: rods one after the other, Levenberg-Marquardt on all unknowns at once
// until the sum of squares is small; the residual that is known from the pose before is not
// integrated again.

#include <cstring>

#include "six_elimination.h"
#include "six_leg_rows.h"

constexpr int UNKNOWNS = LEGS * OWN + LEGS;

class Printed {
   public:
    Printed(const Robot& robot, int steps, double tolerance, double damping)
        : robot(robot), steps(steps), tolerance(tolerance), damping(damping) {}

    void begin(const Unknowns& start, const Pose&) {
        y = start;
        shoot_all(y, tips);
    }

    bool solve(const Pose& pose) {
        Rows f;
        residual(robot, pose, tips, f);
        double left = squares(f), lambda = damping;
        for (int k = 0; k < 100; ++k) {
            if (left < tolerance) return true;
            expand(pose, f);
            for (int tries = 0; tries < 30; ++tries) {
                double change[UNKNOWNS];
                damped_step(normal, right, lambda, change);
                Unknowns other = y;
                Tip<double> others[LEGS];
                Rows g;
                for (int i = 0; i < LEGS * OWN; ++i) other.own[i / OWN][i % OWN] += change[i];
                for (int i = 0; i < LEGS; ++i) other.length[i] += change[LEGS * OWN + i];
                shoot_all(other, others);
                residual(robot, pose, others, g);
                const double now = squares(g);
                if (now < left) {
                    y = other;
                    std::memcpy(&tips, &others, sizeof tips);
                    f = g;
                    left = now;
                    lambda *= 0.5;
                    break;
                }
                lambda *= 2.0;
            }
        }
        return false;
    }

    Unknowns y;

   private:
    void shoot_all(const Unknowns& at, Tip<double> (&out)[LEGS]) {
        for (int leg = 0; leg < LEGS; ++leg)
            shoot<Frame>(robot, robot.base[leg], at.own[leg], at.length[leg], steps, out[leg]);
    }

    static double squares(const Rows& f) {
        double sum = 0.0;
        for (const auto& leg : f.leg)
            for (double row : leg) sum += row * row;
        for (double row : f.balance) sum += row * row;
        return sum;
    }

    // JᵀJ and -Jᵀf, all unknowns at once.
    void expand(const Pose& pose, const Rows& f) {
        Tip<double> shifted[LEGS][OWN];
        for (int leg = 0; leg < LEGS; ++leg)
            for (int k = 0; k < OWN; ++k) {
                double own[OWN];
                std::memcpy(own, y.own[leg], sizeof own);
                own[k] += SHIFT;
                shoot<Frame>(robot, robot.base[leg], own, y.length[leg], steps, shifted[leg][k]);
            }
        Slopes by;
        slopes(robot, pose, tips, shifted, by);
        alignas(64) double J[UNKNOWNS][UNKNOWNS] = {};  // J[unknown][row]
        double rows[UNKNOWNS];
        for (int leg = 0; leg < LEGS; ++leg)
            for (int k = 0; k <= OWN; ++k) {
                double* column = J[k < OWN ? OWN * leg + k : LEGS * OWN + leg];
                for (int i = 0; i < OWN; ++i) column[OWN * leg + i] = by[leg][k][i];
                for (int i = 0; i < 6; ++i) column[LEGS * OWN + i] = by[leg][k][OWN + i];
            }
        std::memcpy(rows, f.leg, sizeof f.leg);
        std::memcpy(rows + LEGS * OWN, f.balance, sizeof f.balance);
        for (int i = 0; i < UNKNOWNS; ++i) {
            for (int j = 0; j <= i; ++j) {
                double sum = 0.0;
                for (int k = 0; k < UNKNOWNS; ++k) sum += J[i][k] * J[j][k];
                normal[i][j] = sum;
            }
            right[i] = 0.0;
            for (int k = 0; k < UNKNOWNS; ++k) right[i] -= J[i][k] * rows[k];
        }
    }

    const Robot& robot;
    const int steps;
    const double tolerance, damping;  // of the sum of squares, and at first
    Tip<double> tips[LEGS];
    double normal[UNKNOWNS][UNKNOWNS], right[UNKNOWNS];
};

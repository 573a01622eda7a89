// What can be spared: 36 rods side by side in vector registers, of which only the tangent turns,
// a step along the slope to each pose, a given number of Newton steps there, and elimination leg
// by leg down to the six lengths.

typedef double Pack __attribute__((vector_size(64)));
constexpr int W = 8, RODS = LEGS * (1 + OWN);

class Lean {
   public:
    Lean(const Robot& robot, int steps, int iterations)
        : robot(robot), steps(steps), iterations(iterations) {}

    void begin(const Unknowns& start, const Pose& pose) {
        y = start;
        expand(pose);
        before = pose;
    }

    bool solve(const Pose& pose) {
        // To first order the residual changes by what the pose changes of its last evaluation.
        Rows f, old;
        residual(robot, pose, tips, f);
        residual(robot, before, tips, old);
        for (int leg = 0; leg < LEGS; ++leg)
            for (int i = 0; i < OWN; ++i) f.leg[leg][i] -= old.leg[leg][i];
        for (int i = 0; i < 6; ++i) f.balance[i] -= old.balance[i];
        step(f);
        before = pose;
        for (int k = 0; k < iterations; ++k) {
            expand(pose);
            residual(robot, pose, tips, f);
            step(f);
        }
        return true;
    }

    Unknowns y;

   private:
    void step(const Rows& f) { eliminated.step(f.leg, f.balance, y.own, y.length); }

    // All tips with their differences, RODS rods in registers of W.
    void expand(const Pose& pose) {
        Tip<double> shifted[LEGS][OWN];
        for (int first = 0; first < RODS; first += W) {
            Pack own[OWN] = {}, length = {}, base[3] = {};
            for (int w = 0; w < W; ++w) {
                const int rod = first + w < RODS ? first + w : RODS - 1;
                const int leg = rod % LEGS, k = rod / LEGS - 1;
                for (int i = 0; i < OWN; ++i) own[i][w] = y.own[leg][i] + (i == k ? SHIFT : 0.0);
                for (int i = 0; i < 3; ++i) base[i][w] = robot.base[leg][i];
                length[w] = y.length[leg];
            }
            Tip<Pack> tip;
            shoot<Tangent>(robot, base, own, length, steps, tip);
            for (int w = 0; w < W && first + w < RODS; ++w) {
                const int rod = first + w, leg = rod % LEGS, k = rod / LEGS - 1;
                Tip<double>& out = k < 0 ? tips[leg] : shifted[leg][k];
                double* to = reinterpret_cast<double*>(&out);
                const Pack* from = reinterpret_cast<const Pack*>(&tip);
                for (unsigned i = 0; i < sizeof out / sizeof(double); ++i) to[i] = from[i][w];
            }
        }
        Slopes by;
        slopes(robot, pose, tips, shifted, by);
        eliminated.factor(by);
    }

    const Robot& robot;
    const int steps, iterations;
    Tip<double> tips[LEGS];
    Pose before;
    Eliminated<LEGS, OWN> eliminated;
};

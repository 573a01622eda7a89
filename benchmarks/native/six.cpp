// Lengths of the legs of a six-leg robot along paths of its platform: shooting with 36 unknowns,
// Runge-Kutta 4, a Jacobian by differences leg by leg, each pose from the solution before it.

#include "six_printed.h"
#include "six_lean.h"

namespace {

// Every path from the same start; returns how many poses are not solved.
template <class Solver>
long follow(Solver& solver, const double* start, const double* origin, const double* poses,
            double* lengths, long paths, long count) {
    const auto& first = *reinterpret_cast<const Unknowns*>(start);
    const auto& before = *reinterpret_cast<const Pose*>(origin);
    const auto* pose = reinterpret_cast<const Pose*>(poses);
    long failed = 0;
    for (long path = 0; path < paths; ++path) {
        solver.begin(first, before);
        for (long k = 0; k < count; ++k, ++pose, lengths += LEGS) {
            failed += !solver.solve(*pose);
            std::memcpy(lengths, solver.y.length, sizeof solver.y.length);
        }
    }
    return failed;
}

}  // namespace

// `numbers` is a Robot, `start` the Unknowns at the pose `origin`, `poses` holds `paths` times
// `count` of them; `lengths` receives those of all poses.
extern "C" long solve_printed(const double* numbers, const double* start, const double* origin,
                              const double* poses, double* lengths, long paths, long count,
                              int steps, double tolerance, double damping) {
    Printed solver(*reinterpret_cast<const Robot*>(numbers), steps, tolerance, damping);
    return follow(solver, start, origin, poses, lengths, paths, count);
}

extern "C" long solve_lean(const double* numbers, const double* start, const double* origin,
                           const double* poses, double* lengths, long paths, long count, int steps,
                           int iterations) {
    Lean solver(*reinterpret_cast<const Robot*>(numbers), steps, iterations);
    return follow(solver, start, origin, poses, lengths, paths, count);
}

// The rods of the six-leg robot: (p, R, n, m) over the arc length by Runge-Kutta 4.
//
// Rods are round, straight and without torsion, and their weight is along z. `T` is a double, or
// a register of several, a rod in each lane.

#include <cmath>

constexpr int LEGS = 6;
constexpr int OWN = 5;  // n(0) and the two moments across the tangent that a leg's base has

struct Robot {
    double shear, stretch, bend;  // compliances 1/GA, 1/EA and 1/EI
    double weight;                // N/m
    double load;                  // weight of the platform, N
    double base[LEGS][3], hole[LEGS][3];
};

template <class T>
struct Tip {
    T p[3], t[3], n[3], m[3];    // position, tangent, force, moment
    T dp[3], dt[3], dm[3];       // their derivatives along the arc; that of n is the weight
};

template <class T>
inline void cross(const T* x, const T* y, T* out) {
    out[0] = x[1] * y[2] - x[2] * y[1];
    out[1] = x[2] * y[0] - x[0] * y[2];
    out[2] = x[0] * y[1] - x[1] * y[0];
}

template <class T>
inline T dot(const T* x, const T* y) {
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

// As published: two columns a, b of R are integrated, the third is their cross product.
struct Frame {
    template <class T>
    struct State {
        T p[3], m[3], a[3], b[3];
    };

    template <class T>
    static State<T> start(const T* base, const T* moment) {
        const T zero = moment[0] - moment[0], one = zero + 1.0;
        return {{base[0], base[1], base[2]},
                {moment[0], moment[1], zero},
                {one, zero, zero},
                {zero, one, zero}};
    }

    template <class T>
    static void tangent(const State<T>& x, T* t) {
        cross(x.a, x.b, t);
    }

    template <class T>
    static void rates(const Robot& robot, const State<T>& x, const T* n, State<T>& out) {
        T c[3];
        cross(x.a, x.b, c);
        const T across = robot.shear * dot(n, x.a), up = robot.shear * dot(n, x.b);
        const T along = 1.0 + robot.stretch * dot(n, c);
        const T u_a = robot.bend * dot(x.m, x.a), u_b = robot.bend * dot(x.m, x.b);
        for (int i = 0; i < 3; ++i) {
            out.p[i] = x.a[i] * across + x.b[i] * up + c[i] * along;
            out.a[i] = -c[i] * u_b;
            out.b[i] = c[i] * u_a;
        }
        cross(n, out.p, out.m);
    }
};

// Of a round section without torsion only the tangent matters.
struct Tangent {
    template <class T>
    struct State {
        T p[3], m[3], t[3];
    };

    template <class T>
    static State<T> start(const T* base, const T* moment) {
        const T zero = moment[0] - moment[0];
        return {{base[0], base[1], base[2]},
                {moment[0], moment[1], zero},
                {zero, zero, zero + 1.0}};
    }

    template <class T>
    static void tangent(const State<T>& x, T* t) {
        for (int i = 0; i < 3; ++i) t[i] = x.t[i];
    }

    template <class T>
    static void rates(const Robot& robot, const State<T>& x, const T* n, State<T>& out) {
        const T along = 1.0 + (robot.stretch - robot.shear) * dot(n, x.t);
        cross(x.m, x.t, out.t);
        for (int i = 0; i < 3; ++i) {
            out.p[i] = x.t[i] * along + robot.shear * n[i];
            out.t[i] *= robot.bend;
        }
        cross(n, out.p, out.m);
    }
};

template <class T, class State, class By>
inline State moved(const State& x, const State& rate, const By& by) {
    State out;
    const T* from = reinterpret_cast<const T*>(&x);
    const T* slope = reinterpret_cast<const T*>(&rate);
    T* to = reinterpret_cast<T*>(&out);
    for (unsigned i = 0; i < sizeof(State) / sizeof(T); ++i) to[i] = from[i] + by * slope[i];
    return out;
}

// The tip of a rod from n(0), (m_x, m_y)(0) and its length.
template <class Rod, class T>
inline void shoot(const Robot& robot, const T* base, const T* own, const T& length, int steps,
                  Tip<T>& tip) {
    using State = typename Rod::template State<T>;
    State x = Rod::template start<T>(base, own + 3), k_1, k_2, k_3, k_4;
    T n[3] = {own[0], own[1], own[2]};
    const T h = length / double(steps), half = 0.5 * h;
    for (int step = 0; step < steps; ++step) {
        Rod::rates(robot, x, n, k_1);
        n[2] += robot.weight * half;
        Rod::rates(robot, moved<T>(x, k_1, half), n, k_2);
        Rod::rates(robot, moved<T>(x, k_2, half), n, k_3);
        n[2] += robot.weight * half;
        Rod::rates(robot, moved<T>(x, k_3, h), n, k_4);
        const State sum = moved<T>(moved<T>(moved<T>(k_1, k_2, 2.0), k_3, 2.0), k_4, 1.0);
        x = moved<T>(x, sum, h / 6.0);
    }
    Rod::rates(robot, x, n, k_1);
    // The tangent's derivative is that of a rod without torsion in either state.
    Rod::tangent(x, tip.t);
    cross(x.m, tip.t, tip.dt);
    for (int i = 0; i < 3; ++i) {
        tip.p[i] = x.p[i];
        tip.n[i] = n[i];
        tip.m[i] = x.m[i];
        tip.dp[i] = k_1.p[i];
        tip.dt[i] *= robot.bend;
        tip.dm[i] = k_1.m[i];
    }
}

// The linear systems of the six-leg robot: dense and damped, or leg by leg.

#include <cmath>

// Solves (N + λ) x = right for a symmetric N of which the lower triangle is given.
template <int N>
void damped_step(const double (&normal)[N][N], const double (&right)[N], double lambda,
                 double* x) {
    double L[N][N];
    for (int i = 0; i < N; ++i) {
        for (int j = 0; j <= i; ++j) {
            double sum = normal[i][j] + (i == j ? lambda : 0.0);
            for (int k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
            L[i][j] = i == j ? std::sqrt(sum) : sum / L[j][j];
        }
        double sum = right[i];
        for (int k = 0; k < i; ++k) sum -= L[i][k] * x[k];
        x[i] = sum / L[i][i];
    }
    for (int i = N - 1; i >= 0; --i) {
        double sum = x[i];
        for (int k = i + 1; k < N; ++k) sum -= L[k][i] * x[k];
        x[i] = sum / L[i][i];
    }
}

// The inverse of a small matrix by Gauss and Jordan, with pivots.
template <int N>
void invert(double (&a)[N][N], double (&out)[N][N]) {
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) out[i][j] = i == j;
    for (int k = 0; k < N; ++k) {
        int best = k;
        for (int i = k + 1; i < N; ++i)
            if (std::fabs(a[i][k]) > std::fabs(a[best][k])) best = i;
        for (int j = 0; j < N; ++j) {
            const double x = a[k][j], y = out[k][j];
            a[k][j] = a[best][j], out[k][j] = out[best][j];
            a[best][j] = x, out[best][j] = y;
        }
        const double pivot = 1.0 / a[k][k];
        for (int j = 0; j < N; ++j) a[k][j] *= pivot, out[k][j] *= pivot;
        for (int i = 0; i < N; ++i) {
            if (i == k) continue;
            const double factor = a[i][k];
            for (int j = 0; j < N; ++j) {
                a[i][j] -= factor * a[k][j];
                out[i][j] -= factor * out[k][j];
            }
        }
    }
}

// Rows of each leg in its own unknowns and its length, and six rows in all of them.
template <int LEGS, int OWN>
class Eliminated {
   public:
    void factor(const double (&by)[LEGS][OWN + 1][OWN + 6]) {
        double left[6][6];
        for (int leg = 0; leg < LEGS; ++leg) {
            double own[OWN][OWN];
            for (int i = 0; i < OWN; ++i)
                for (int k = 0; k < OWN; ++k) own[i][k] = by[leg][k][i];
            invert(own, inverse[leg]);
            for (int i = 0; i < OWN; ++i) {
                follow[leg][i] = 0.0;
                for (int k = 0; k < OWN; ++k)
                    follow[leg][i] -= inverse[leg][i][k] * by[leg][OWN][k];
            }
            for (int i = 0; i < 6; ++i) {
                left[i][leg] = by[leg][OWN][OWN + i];
                for (int k = 0; k < OWN; ++k) {
                    shared[leg][i][k] = by[leg][k][OWN + i];
                    left[i][leg] += shared[leg][i][k] * follow[leg][k];
                }
            }
        }
        invert(left, lengths);
    }

    // Adds the Newton step of a residual to the unknowns.
    void step(const double (&rows)[LEGS][OWN], const double (&balance)[6],
              double (&own)[LEGS][OWN], double (&length)[LEGS]) const {
        double change[LEGS][OWN], right[6];
        for (int i = 0; i < 6; ++i) right[i] = -balance[i];
        for (int leg = 0; leg < LEGS; ++leg) {
            for (int i = 0; i < OWN; ++i) {
                change[leg][i] = 0.0;
                for (int k = 0; k < OWN; ++k) change[leg][i] -= inverse[leg][i][k] * rows[leg][k];
            }
            for (int i = 0; i < 6; ++i)
                for (int k = 0; k < OWN; ++k) right[i] -= shared[leg][i][k] * change[leg][k];
        }
        for (int leg = 0; leg < LEGS; ++leg) {
            double further = 0.0;
            for (int i = 0; i < 6; ++i) further += lengths[leg][i] * right[i];
            length[leg] += further;
            for (int i = 0; i < OWN; ++i) own[leg][i] += change[leg][i] + follow[leg][i] * further;
        }
    }

   private:
    double inverse[LEGS][OWN][OWN], follow[LEGS][OWN], shared[LEGS][6][OWN], lengths[6][6];
};

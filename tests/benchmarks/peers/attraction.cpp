// Attraction between every two particles, summed up directly: what a good programmer writes by hand.
#include <cmath>
#include <cstdint>

template <typename real>
static void attract(const real *x, const real *y, const real *z, const real *m, real *ax, real *ay, real *az,
                    int64_t count, real softening2) {
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) {
        real sx = 0, sy = 0, sz = 0;
        const real xi = x[i], yi = y[i], zi = z[i];
#pragma omp simd reduction(+ : sx, sy, sz)
        for (int64_t j = 0; j < count; j++) {
            const real dx = x[j] - xi, dy = y[j] - yi, dz = z[j] - zi;
            const real d2 = dx * dx + dy * dy + dz * dz + softening2;
            const real factor = m[j] / (d2 * std::sqrt(d2));
            sx += factor * dx;
            sy += factor * dy;
            sz += factor * dz;
        }
        ax[i] = sx;
        ay[i] = sy;
        az[i] = sz;
    }
}

extern "C" void attract_single(const float *x, const float *y, const float *z, const float *m, float *ax, float *ay,
                               float *az, int64_t count, double softening2) {
    attract<float>(x, y, z, m, ax, ay, az, count, static_cast<float>(softening2));
}

extern "C" void attract_double(const double *x, const double *y, const double *z, const double *m, double *ax,
                               double *ay, double *az, int64_t count, double softening2) {
    attract<double>(x, y, z, m, ax, ay, az, count, softening2);
}

// The dust in C++, as one writes it for speed: an array for each component, the steps of a frame in registers,
// threads and SIMD by OpenMP. Numbers of the scene are arguments; its forces and contacts are compiled in.
//
// Twice: with the number of steps an argument too, as in a program that reads scenes; and with the eight steps
// compiled in, so that the compiler unrolls them, and conditions without branches.
#include <cmath>
#include <cstdint>

namespace {

constexpr int unrolled_steps = 8;

struct Numbers {
    float dt, gravity, drag, quadratic_drag, mass_strength, mass_height, softening2, restitution, friction;
};

struct Particle {
    float x, y, z, u, v, w;
};

struct Acceleration {
    float x, y, z;
};

template <int forces>
inline Acceleration acceleration(const Particle& q, const Numbers& c) {
    float rate = c.drag;
    if (forces == 4) rate += c.quadratic_drag * std::sqrt(q.u * q.u + q.v * q.v + q.w * q.w);
    Acceleration a{-rate * q.u, -c.gravity - rate * q.v, -rate * q.w};
    if (forces == 4) {
        const float dy = q.y - c.mass_height;
        const float r2 = q.x * q.x + dy * dy + q.z * q.z + c.softening2;
        const float pull = c.mass_strength / (r2 * std::sqrt(r2));
        a.x -= pull * q.x;
        a.y -= pull * dy;
        a.z -= pull * q.z;
    }
    return a;
}

inline Particle moved(const Particle& q, const Particle& at, const Acceleration& a, float h) {
    return {q.x + h * at.u, q.y + h * at.v, q.z + h * at.w, q.u + h * a.x, q.v + h * a.y, q.w + h * a.z};
}

template <int forces>
inline Particle symplectic_euler(Particle q, const Numbers& c) {
    const Acceleration a = acceleration<forces>(q, c);
    q.u += c.dt * a.x;
    q.v += c.dt * a.y;
    q.w += c.dt * a.z;
    q.x += c.dt * q.u;
    q.y += c.dt * q.v;
    q.z += c.dt * q.w;
    return q;
}

template <int forces>
inline Particle rk4(const Particle& q, const Numbers& c) {
    const Acceleration a1 = acceleration<forces>(q, c);
    const Particle q2 = moved(q, q, a1, c.dt / 2);
    const Acceleration a2 = acceleration<forces>(q2, c);
    const Particle q3 = moved(q, q2, a2, c.dt / 2);
    const Acceleration a3 = acceleration<forces>(q3, c);
    const Particle q4 = moved(q, q3, a3, c.dt);
    const Acceleration a4 = acceleration<forces>(q4, c);
    const float h = c.dt / 6;
    return {q.x + h * (q.u + 2 * (q2.u + q3.u) + q4.u), q.y + h * (q.v + 2 * (q2.v + q3.v) + q4.v),
            q.z + h * (q.w + 2 * (q2.w + q3.w) + q4.w), q.u + h * (a1.x + 2 * (a2.x + a3.x) + a4.x),
            q.v + h * (a1.y + 2 * (a2.y + a3.y) + a4.y), q.w + h * (a1.z + 2 * (a2.z + a3.z) + a4.z)};
}

template <bool rubs>
inline Particle off_plane(const Particle& before, Particle q, const Numbers& c) {
    const bool hit = (q.y < 0) & (q.v < 0);
    const float rebound = -c.restitution * q.v;
    const bool rests = rebound <= -2 * (q.v - before.v);
    const float v = rests ? 0.0f : rebound;
    const float y = rests ? 0.0f : -c.restitution * q.y;
    if (rubs) {
        const float sliding = std::sqrt(q.u * q.u + q.w * q.w) + 1e-30f;
        const float kept = std::fmax(0.0f, 1 - c.friction * (v - q.v) / sliding);
        const bool stays = hit & rests & (kept <= 0);
        q.x = stays ? before.x : q.x;
        q.z = stays ? before.z : q.z;
        q.u = hit ? kept * q.u : q.u;
        q.w = hit ? kept * q.w : q.w;
    }
    q.y = hit ? y : q.y;
    q.v = hit ? v : q.v;
    return q;
}

// Called with references into the arrays, whose particles stay in registers between the first line and the last.
template <int order, int forces, bool rubs>
inline void unrolled(float& x, float& y, float& z, float& u, float& v, float& w, const Numbers& c) {
    Particle q{x, y, z, u, v, w};
    for (int s = 0; s < unrolled_steps; s++) {
        const Particle before = q;
        q = order == 4 ? rk4<forces>(before, c) : symplectic_euler<forces>(before, c);
        q = off_plane<rubs>(before, q, c);
    }
    x = q.x;
    y = q.y;
    z = q.z;
    u = q.u;
    v = q.v;
    w = q.w;
}

template <int order, int forces, bool rubs>
void frame(float* __restrict x, float* __restrict y, float* __restrict z, float* __restrict u,
           float* __restrict v, float* __restrict w, int64_t count, const Numbers& numbers) {
    const Numbers c = numbers;
#pragma omp parallel for simd schedule(static)
    for (int64_t i = 0; i < count; i++) unrolled<order, forces, rubs>(x[i], y[i], z[i], u[i], v[i], w[i], c);
}

}  // namespace

#define FRAME(name, order, forces, rubs)                                                                   \
    extern "C" void name(float* x, float* y, float* z, float* u, float* v, float* w, int64_t count, int,  \
                         const Numbers* numbers) {                                                         \
        frame<order, forces, rubs>(x, y, z, u, v, w, count, *numbers);                                     \
    }

FRAME(symplectic_euler_2_unrolled, 1, 2, false)
FRAME(symplectic_euler_2_friction_unrolled, 1, 2, true)
FRAME(rk4_4_unrolled, 4, 4, false)

extern "C" void symplectic_euler_2(float* __restrict px, float* __restrict py, float* __restrict pz,
                                   float* __restrict pu, float* __restrict pv, float* __restrict pw,
                                   int64_t count, int steps, const Numbers* numbers) {
    const Numbers c = *numbers;
#pragma omp parallel for simd schedule(static)
    for (int64_t i = 0; i < count; i++) {
        float x = px[i], y = py[i], z = pz[i], u = pu[i], v = pv[i], w = pw[i];
        for (int s = 0; s < steps; s++) {
            const float gained = c.dt * (-c.gravity - c.drag * v);
            u -= c.dt * c.drag * u;
            v += gained;
            w -= c.dt * c.drag * w;
            x += c.dt * u;
            y += c.dt * v;
            z += c.dt * w;
            if (y < 0 && v < 0) {
                const float rebound = -c.restitution * v;
                const bool rests = rebound <= -2 * gained;
                v = rests ? 0 : rebound;
                y = rests ? 0 : -c.restitution * y;
            }
        }
        px[i] = x;
        py[i] = y;
        pz[i] = z;
        pu[i] = u;
        pv[i] = v;
        pw[i] = w;
    }
}

// A dam break of weakly compressible fluid: what a good programmer writes by hand. Particles are sorted into cells as
// wide as the kernel reaches at every step, images stand behind the floor and the wall, and pairs are found cell by cell.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

struct Body {
    float x, y, u, v;
};

struct Dam {
    std::vector<Body> bodies, sorted;
    std::vector<float> surplus, stress;
    std::vector<int32_t> source, number, starts, cells;
    float h, mass, density, stiffness, viscosity, gravity, dt;
    int64_t count;
    int across;
    float low_x, low_y;
};

static float bell(float q2, float inverse_h) {
    const float q = std::sqrt(q2) * inverse_h, s = std::max(1.0f - 0.5f * q, 0.0f);
    return s * s * s * s * (1.0f + 2.0f * q);
}

static void sort(Dam &dam) {
    const float reach = 2.0f * dam.h;
    const size_t count = dam.count;
    std::vector<Body> all(dam.bodies);
    dam.source.resize(count);
    for (size_t i = 0; i < count; i++) dam.source[i] = i;
    for (size_t i = 0; i < count; i++) {
        const Body b = dam.bodies[i];
        const bool wall = b.x < reach, floor = b.y < reach;
        if (wall) all.push_back({-b.x, b.y, -b.u, b.v}), dam.source.push_back(i);
        if (floor) all.push_back({b.x, -b.y, b.u, -b.v}), dam.source.push_back(i);
        if (wall && floor) all.push_back({-b.x, -b.y, -b.u, -b.v}), dam.source.push_back(i);
    }
    float high_x = -1e30f, high_y = -1e30f;
    dam.low_x = dam.low_y = 1e30f;
    for (const Body &b : all) {
        dam.low_x = std::min(dam.low_x, b.x), dam.low_y = std::min(dam.low_y, b.y);
        high_x = std::max(high_x, b.x), high_y = std::max(high_y, b.y);
    }
    // One empty cell around all others.
    dam.across = static_cast<int>((high_x - dam.low_x) / reach) + 3;
    const int rows = static_cast<int>((high_y - dam.low_y) / reach) + 3;
    dam.starts.assign(static_cast<size_t>(dam.across) * rows + 1, 0);
    dam.cells.resize(all.size());
    for (size_t i = 0; i < all.size(); i++) {
        const int cx = static_cast<int>((all[i].x - dam.low_x) / reach) + 1;
        const int cy = static_cast<int>((all[i].y - dam.low_y) / reach) + 1;
        dam.cells[i] = cy * dam.across + cx;
        dam.starts[dam.cells[i] + 1]++;
    }
    for (size_t k = 1; k < dam.starts.size(); k++) dam.starts[k] += dam.starts[k - 1];
    std::vector<int32_t> next(dam.starts);
    dam.sorted.resize(all.size()), dam.number.resize(all.size()), dam.stress.resize(all.size());
    std::vector<int32_t> cells(all.size());
    for (size_t i = 0; i < all.size(); i++) {
        const int32_t place = next[dam.cells[i]]++;
        dam.sorted[place] = all[i], dam.number[place] = i, cells[place] = dam.cells[i];
    }
    dam.cells.swap(cells);
}

template <typename Work> static void around(const Dam &dam, int32_t i, Work work) {
    for (int row = -1; row <= 1; row++) {
        const int32_t cell = dam.cells[i] + row * dam.across;
        const int32_t first = dam.starts[cell - 1], last = dam.starts[cell + 2];
        work(first, last);
    }
}

static void weigh(Dam &dam, bool begins) {
    const float reach2 = 4.0f * dam.h * dam.h, height = 7.0f / (4.0f * M_PI * dam.h * dam.h), inverse = 1.0f / dam.h;
    const int64_t places = dam.sorted.size();
    std::vector<float> of_body(dam.count);
#pragma omp parallel for schedule(dynamic, 512)
    for (int64_t i = 0; i < places; i++) {
        if (dam.number[i] >= dam.count) continue;
        const Body b = dam.sorted[i];
        float sum = 0;
        around(dam, i, [&](int32_t first, int32_t last) {
#pragma omp simd reduction(+ : sum)
            for (int32_t j = first; j < last; j++) {
                const float dx = b.x - dam.sorted[j].x, dy = b.y - dam.sorted[j].y, d2 = dx * dx + dy * dy;
                sum += d2 < reach2 ? bell(d2, inverse) : 0.0f;
            }
        });
        sum *= dam.mass * height;
        if (begins) dam.surplus[dam.number[i]] = dam.density - sum;
        const float ratio = std::max((sum + dam.surplus[dam.number[i]]) / dam.density, 1.0f);
        const float r3 = ratio * ratio * ratio, density = ratio * dam.density;
        of_body[dam.number[i]] = dam.stiffness * (r3 * r3 * ratio - 1.0f) / (density * density);
    }
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < places; i++) dam.stress[i] = of_body[dam.source[dam.number[i]]];
}

static void push(Dam &dam) {
    const float h2 = dam.h * dam.h, reach2 = 4.0f * h2, inverse = 1.0f / dam.h;
    const float height = 7.0f / (4.0f * M_PI * h2 * h2);
    const int64_t places = dam.sorted.size();
#pragma omp parallel for schedule(dynamic, 512)
    for (int64_t i = 0; i < places; i++) {
        if (dam.number[i] >= dam.count) continue;
        const Body b = dam.sorted[i];
        const float stress = dam.stress[i];
        float ax = 0, ay = 0;
        around(dam, i, [&](int32_t first, int32_t last) {
#pragma omp simd reduction(+ : ax, ay)
            for (int32_t j = first; j < last; j++) {
                const Body o = dam.sorted[j];
                const float dx = b.x - o.x, dy = b.y - o.y, d2 = dx * dx + dy * dy;
                const float s = std::max(1.0f - 0.5f * std::sqrt(d2) * inverse, 0.0f);
                const float closing = std::min(dx * (b.u - o.u) + dy * (b.v - o.v), 0.0f);
                const float push = stress + dam.stress[j] - dam.viscosity * closing / (d2 + 0.01f * h2);
                const float factor = d2 < reach2 ? 5.0f * s * s * s * push : 0.0f;
                ax += factor * dx, ay += factor * dy;
            }
        });
        Body &moved = dam.bodies[dam.number[i]];
        moved.u += dam.dt * dam.mass * height * ax;
        moved.v += dam.dt * (dam.mass * height * ay - dam.gravity);
        moved.x = std::abs(moved.x + dam.dt * moved.u), moved.y = std::abs(moved.y + dam.dt * moved.v);
    }
}

extern "C" void *make(const float *x, const float *y, const float *u, const float *v, int64_t count,
                      const float *numbers) {
    Dam *dam = new Dam;
    dam->count = count;
    for (int64_t i = 0; i < count; i++) dam->bodies.push_back({x[i], y[i], u[i], v[i]});
    dam->surplus.resize(count);
    dam->h = numbers[0], dam->mass = numbers[1], dam->density = numbers[2], dam->stiffness = numbers[3];
    dam->viscosity = numbers[4], dam->gravity = numbers[5], dam->dt = numbers[6];
    sort(*dam);
    weigh(*dam, true);
    return dam;
}

extern "C" void advance(void *handle, int64_t steps) {
    Dam &dam = *static_cast<Dam *>(handle);
    for (int64_t step = 0; step < steps; step++) {
        sort(dam);
        weigh(dam, false);
        push(dam);
    }
}

extern "C" void read(void *handle, float *x, float *y) {
    const Dam &dam = *static_cast<Dam *>(handle);
    for (int64_t i = 0; i < dam.count; i++) x[i] = dam.bodies[i].x, y[i] = dam.bodies[i].y;
}

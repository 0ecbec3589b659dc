// A liquid of Lennard-Jones atoms in a periodic cube, by Verlet's lists: what a good programmer writes by hand.
//
// Atoms are sorted by cells whenever lists are made. Copies of those near the faces stand behind them, so that pairs
// need no folding. Lists name every pair twice, so that no two threads write to the same atom.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

using std::vector;

struct Liquid {
    int64_t count;
    double edge, cutoff, skin, dt;
    vector<double> state[6], force[3], at[3], origin[3];
    vector<int32_t> id, starts, lists, copied;
    vector<double> shift[3];
};

static int cell_of(double x, double low, double size, int cells) {
    return std::min(std::max(static_cast<int>((x - low) / size), 0), cells - 1);
}

// Wraps atoms into the cube and puts them into the order of cells.
static void sort(Liquid &q, int cells) {
    const double size = q.edge / cells;
    vector<int32_t> keys(q.count), order(q.count), first(static_cast<size_t>(cells) * cells * cells + 1);
    for (int64_t i = 0; i < q.count; i++) {
        int64_t key = 0;
        for (int c = 0; c < 3; c++) {
            q.state[c][i] -= q.edge * std::floor(q.state[c][i] / q.edge);
            key = key * cells + cell_of(q.state[c][i], 0, size, cells);
        }
        keys[i] = static_cast<int32_t>(key);
        first[key + 1]++;
    }
    for (size_t k = 1; k < first.size(); k++) first[k] += first[k - 1];
    for (int64_t i = 0; i < q.count; i++) order[first[keys[i]]++] = static_cast<int32_t>(i);
    vector<int32_t> id(q.count);
    for (int64_t i = 0; i < q.count; i++) id[i] = q.id[order[i]];
    q.id.swap(id);
    vector<double> sorted(q.count);
    for (auto &row : q.state) {
        for (int64_t i = 0; i < q.count; i++) sorted[i] = row[order[i]];
        row.swap(sorted);
    }
}

static void copy(Liquid &q) {
    const int64_t copies = q.copied.size();
    for (int c = 0; c < 3; c++) {
        std::copy(q.state[c].begin(), q.state[c].end(), q.at[c].begin());
#pragma omp parallel for
        for (int64_t k = 0; k < copies; k++) q.at[c][q.count + k] = q.state[c][q.copied[k]] + q.shift[c][k];
    }
}

// Copies of atoms within reach of the faces.
static void find_copies(Liquid &q, double reach) {
    q.copied.clear();
    for (auto &row : q.shift) row.clear();
    for (int64_t i = 0; i < q.count; i++)
        for (int turn = 0; turn < 27; turn++) {
            const int turns[3] = {turn / 9 - 1, turn / 3 % 3 - 1, turn % 3 - 1};
            bool near = turn != 13;
            for (int c = 0; c < 3; c++) {
                const double x = q.state[c][i] + turns[c] * q.edge;
                near = near && x > -reach && x < q.edge + reach;
            }
            if (!near) continue;
            q.copied.push_back(static_cast<int32_t>(i));
            for (int c = 0; c < 3; c++) q.shift[c].push_back(turns[c] * q.edge);
        }
    for (int c = 0; c < 3; c++) q.at[c].resize(q.count + q.copied.size());
    copy(q);
}

// Lists of all within reach, from cells half as wide.
static void list(Liquid &q, double reach) {
    const int cells = static_cast<int>((q.edge + 2 * reach) / (0.5 * reach));
    const double size = (q.edge + 2 * reach) / cells;
    const int64_t all = q.at[0].size();
    vector<int32_t> keys(all), members(all), first(static_cast<size_t>(cells) * cells * cells + 1);
    for (int64_t i = 0; i < all; i++) {
        int64_t key = 0;
        for (int c = 0; c < 3; c++) key = key * cells + cell_of(q.at[c][i], -reach, size, cells);
        keys[i] = static_cast<int32_t>(key);
        first[key + 1]++;
    }
    for (size_t k = 1; k < first.size(); k++) first[k] += first[k - 1];
    vector<int32_t> next(first.begin(), first.end() - 1);
    for (int64_t i = 0; i < all; i++) members[next[keys[i]]++] = static_cast<int32_t>(i);
    const int room = 192;
    q.lists.resize(q.count * room);
    q.starts.resize(q.count);
    const double *x = q.at[0].data(), *y = q.at[1].data(), *z = q.at[2].data();
#pragma omp parallel for schedule(static, 64)
    for (int64_t i = 0; i < q.count; i++) {
        const int a = cell_of(x[i], -reach, size, cells), b = cell_of(y[i], -reach, size, cells);
        const int c = cell_of(z[i], -reach, size, cells);
        int32_t length = 0, *mine = &q.lists[i * room];
        for (int u = std::max(a - 3, 0); u <= std::min(a + 3, cells - 1); u++)
            for (int v = std::max(b - 3, 0); v <= std::min(b + 3, cells - 1); v++) {
                const int64_t row = (static_cast<int64_t>(u) * cells + v) * cells;
                const int begin = first[row + std::max(c - 3, 0)], end = first[row + std::min(c + 3, cells - 1) + 1];
                for (int k = begin; k < end; k++) {
                    const int32_t j = members[k];
                    const double dx = x[i] - x[j], dy = y[i] - y[j], dz = z[i] - z[j];
                    mine[length] = j;
                    length += (dx * dx + dy * dy + dz * dz < reach * reach) & (j != i) & (length < room - 1);
                }
            }
        q.starts[i] = length;
    }
    for (int c = 0; c < 3; c++) q.origin[c] = q.state[c];
}

static bool moved(const Liquid &q) {
    double most = 0;
#pragma omp parallel for simd reduction(max : most)
    for (int64_t i = 0; i < q.count; i++) {
        const double dx = q.state[0][i] - q.origin[0][i], dy = q.state[1][i] - q.origin[1][i];
        const double dz = q.state[2][i] - q.origin[2][i];
        most = std::max(most, dx * dx + dy * dy + dz * dz);
    }
    return most > 0.25 * q.skin * q.skin;
}

static void attract(Liquid &q) {
    if (q.origin[0].empty() || moved(q)) {
        const double reach = q.cutoff + q.skin;
        sort(q, static_cast<int>(q.edge / reach));
        find_copies(q, reach);
        list(q, reach);
    } else
        copy(q);
    const double *x = q.at[0].data(), *y = q.at[1].data(), *z = q.at[2].data(), cutoff2 = q.cutoff * q.cutoff;
    // What makes the force zero at the cutoff.
    const double last = (24 - 48 / std::pow(q.cutoff, 6)) / std::pow(q.cutoff, 8);
#pragma omp parallel for schedule(static, 64)
    for (int64_t i = 0; i < q.count; i++) {
        const int32_t *mine = &q.lists[i * 192], length = q.starts[i];
        double sx = 0, sy = 0, sz = 0;
#pragma omp simd reduction(+ : sx, sy, sz)
        for (int k = 0; k < length; k++) {
            const int32_t j = mine[k];
            const double dx = x[i] - x[j], dy = y[i] - y[j], dz = z[i] - z[j];
            const double d2 = dx * dx + dy * dy + dz * dz, inverse2 = 1 / d2, inverse6 = inverse2 * inverse2 * inverse2;
            const double factor = d2 < cutoff2 ? inverse2 * inverse6 * (48 * inverse6 - 24) + last : 0;
            sx += factor * dx;
            sy += factor * dy;
            sz += factor * dz;
        }
        q.force[0][i] = sx;
        q.force[1][i] = sy;
        q.force[2][i] = sz;
    }
}

extern "C" {
Liquid *liquid_new(const double *state, int64_t count, double edge, double cutoff, double skin, double dt) {
    auto *q = new Liquid{count, edge, cutoff, skin, dt, {}, {}, {}, {}, {}, {}, {}, {}, {}};
    for (int c = 0; c < 6; c++) q->state[c].assign(state + c * count, state + (c + 1) * count);
    for (auto &row : q->force) row.resize(count);
    for (int64_t i = 0; i < count; i++) q->id.push_back(static_cast<int32_t>(i));
    attract(*q);
    return q;
}

// Steps of velocity Verlet.
void liquid_advance(Liquid *q, int64_t steps) {
    for (int64_t s = 0; s < steps; s++) {
        for (int c = 0; c < 3; c++) {
#pragma omp parallel for simd
            for (int64_t i = 0; i < q->count; i++) {
                q->state[c + 3][i] += 0.5 * q->dt * q->force[c][i];
                q->state[c][i] += q->dt * q->state[c + 3][i];
            }
        }
        attract(*q);
        for (int c = 0; c < 3; c++) {
#pragma omp parallel for simd
            for (int64_t i = 0; i < q->count; i++) q->state[c + 3][i] += 0.5 * q->dt * q->force[c][i];
        }
    }
}

void liquid_state(const Liquid *q, double *state) {
    for (int c = 0; c < 6; c++)
        for (int64_t i = 0; i < q->count; i++) state[c * q->count + q->id[i]] = q->state[c][i];
}

void liquid_delete(Liquid *q) { delete q; }
}

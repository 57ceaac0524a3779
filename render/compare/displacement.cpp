#include "render/compare/displacement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace diff {

namespace {

/// Pixels that a fit looks at: enough for a shift to a hundredth of a pixel.
constexpr std::size_t most_points = 800;
/// Pixels that the search for a whole shift looks at, for each shift.
constexpr std::size_t most_search_points = 120;
/// Steps of the fit; each takes the rest of the shift to about its square.
constexpr int iterations = 5;
/// Where the slopes in one direction are weaker than this share of those across (squared), the area is an edge,
/// and the shift along it is not seen.
constexpr double least_slope_ratio = 0.1;
/// A fit that has left its start by this much [px] has not converged.
constexpr double most_refinement = 3.0;
/// A far shift [px] counts where the differences spread by at least this share of it along its direction: what has moved
/// differs at its old and at its new place. A thin line that has grown paler is explained by taking it away, too.
constexpr double far_shift = 1.5;
constexpr double least_spread = 0.4;
/// A shift that leaves more than this share of the differences may be a far one: whole shifts are tried.
constexpr double far_rest = 0.5;

struct Point {
    int x, y;
};

struct Shift {
    double x = 0.0, y = 0.0;
};

std::vector<Point> points_of(const Area& area, int width, int height, std::size_t most) {
    std::vector<Point> points;
    const std::size_t all = area.cells.size() * cell_size * cell_size;
    const std::size_t stride = std::max<std::size_t>(1, (all + most - 1) / most);
    const int columns = cell_count(width);
    for (std::size_t i = 0; i < all; i += stride) {
        const int cell = area.cells[i / (cell_size * cell_size)];
        // A step of 5 through the 16 pixels of a cell meets all of them, in mixed order.
        const int inside = static_cast<int>(i * 5 % (cell_size * cell_size));
        const Point point{cell % columns * cell_size + inside % cell_size,
                          cell / columns * cell_size + inside / cell_size};
        if (point.x < width && point.y < height) {
            points.push_back(point);
        }
    }
    return points;
}

/// Standard deviation [px] of the differing pixels' places along a shift.
double spread_along(const DifferenceMap& map, const std::vector<Point>& points, const Shift& u) {
    double weight = 0.0, sum = 0.0, squares = 0.0;
    for (const Point& p : points) {
        const std::size_t pixel =
            static_cast<std::size_t>(p.y) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(p.x);
        const double w = map.smooth[pixel];
        const double place = (u.x * p.x + u.y * p.y) / std::hypot(u.x, u.y);
        weight += w;
        sum += w * place;
        squares += w * place * place;
    }
    const double mean = weight > 0.0 ? sum / weight : 0.0;
    return weight > 0.0 ? std::sqrt(std::max(0.0, squares / weight - mean * mean)) : 0.0;
}

/// Pixels at a fixed offset from points, and between pixels, linear; beyond the picture its border repeats.
class Neighbour {
public:
    Neighbour(const Picture& picture, int dx, int dy) : picture_(picture), dx_(dx), dy_(dy) {}

    /// Its three channels.
    const std::uint8_t* at(const Point& p) const {
        const int column = std::clamp(p.x + dx_, 0, picture_.width - 1);
        const int row = std::clamp(p.y + dy_, 0, picture_.height - 1);
        return picture_.rgb.data() +
               (static_cast<std::size_t>(row) * static_cast<std::size_t>(picture_.width) + static_cast<std::size_t>(column)) * 3;
    }

private:
    const Picture& picture_;
    int dx_;
    int dy_;
};

/// The picture moved by u, between its pixels linear.
class Moved {
public:
    Moved(const Picture& picture, const Shift& u)
        : left_(static_cast<int>(std::floor(-u.x))), top_(static_cast<int>(std::floor(-u.y))), fx_(-u.x - left_),
          fy_(-u.y - top_), corners_{{picture, left_, top_}, {picture, left_ + 1, top_}, {picture, left_, top_ + 1},
                                     {picture, left_ + 1, top_ + 1}} {}

    std::array<double, 3> at(const Point& p) const {
        const std::uint8_t* upper[] = {corners_[0].at(p), corners_[1].at(p)};
        const std::uint8_t* lower[] = {corners_[2].at(p), corners_[3].at(p)};
        std::array<double, 3> value;
        for (std::size_t c = 0; c < 3; ++c) {
            value[c] = (1.0 - fy_) * ((1.0 - fx_) * upper[0][c] + fx_ * upper[1][c]) +
                       fy_ * ((1.0 - fx_) * lower[0][c] + fx_ * lower[1][c]);
        }
        return value;
    }

private:
    int left_;
    int top_;
    double fx_;
    double fy_;
    Neighbour corners_[4];
};

class Fit {
public:
    Fit(const Picture& a, const Picture& b) : a_(a), b_(b) {}

    /// Sum of squared differences that the shift leaves.
    double rest(const std::vector<Point>& points, const Shift& u) const {
        const Moved moved(a_, u);
        const Neighbour here(b_, 0, 0);
        double sum = 0.0;
        for (const Point& p : points) {
            const std::array<double, 3> value = moved.at(p);
            const std::uint8_t* b = here.at(p);
            for (std::size_t c = 0; c < 3; ++c) {
                sum += (b[c] - value[c]) * (b[c] - value[c]);
            }
        }
        return sum;
    }

    Shift whole_shift(const std::vector<Point>& points, int reach) const {
        Shift best;
        double least = whole_rest(points, 0, 0);
        for (int y = -reach; y <= reach; ++y) {
            for (int x = -reach; x <= reach; ++x) {
                const double now = whole_rest(points, x, y);
                if (now < least) {
                    least = now;
                    best = {static_cast<double>(x), static_cast<double>(y)};
                }
            }
        }
        return best;
    }

    /// One step of Gauss and Newton on rest(). What cannot be seen, a shift along straight edges, stays zero.
    Shift improved(const std::vector<Point>& points, const Shift& u) const {
        double xx = 0.0, xy = 0.0, yy = 0.0, x_r = 0.0, y_r = 0.0;
        const int ux = static_cast<int>(std::lround(u.x));
        const int uy = static_cast<int>(std::lround(u.y));
        const Moved moved(a_, u);
        const Neighbour here(b_, 0, 0);
        const Neighbour right[] = {{b_, 1, 0}, {a_, 1 - ux, -uy}}, left[] = {{b_, -1, 0}, {a_, -1 - ux, -uy}};
        const Neighbour below[] = {{b_, 0, 1}, {a_, -ux, 1 - uy}}, above[] = {{b_, 0, -1}, {a_, -ux, -1 - uy}};
        for (const Point& p : points) {
            const std::array<double, 3> value = moved.at(p);
            const std::uint8_t* b = here.at(p);
            // Mean of both pictures' slopes [levels/px].
            int x4[3] = {}, y4[3] = {};
            for (int k = 0; k < 2; ++k) {
                const std::uint8_t *r = right[k].at(p), *l = left[k].at(p), *d = below[k].at(p), *t = above[k].at(p);
                for (std::size_t c = 0; c < 3; ++c) {
                    x4[c] += r[c] - l[c];
                    y4[c] += d[c] - t[c];
                }
            }
            for (std::size_t c = 0; c < 3; ++c) {
                const double gx = 0.25 * x4[c], gy = 0.25 * y4[c];
                // What the whole shift is to explain: the rest, and what u explains already.
                const double r = b[c] - value[c] - gx * u.x - gy * u.y;
                xx += gx * gx;
                xy += gx * gy;
                yy += gy * gy;
                x_r -= gx * r;
                y_r -= gy * r;
            }
        }
        // Principal directions of the slopes: (cos, sin) of the steeper one.
        const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
        const double spread = std::hypot(0.5 * (xx - yy), xy);
        const double steep = 0.5 * (xx + yy) + spread;
        const double flat = 0.5 * (xx + yy) - spread;
        if (steep <= 0.0) {
            return u;
        }
        const double cosine = std::cos(angle);
        const double sine = std::sin(angle);
        const double along_steep = (cosine * x_r + sine * y_r) / steep;
        const double along_flat = flat < least_slope_ratio * steep ? 0.0 : (cosine * y_r - sine * x_r) / flat;
        return {cosine * along_steep - sine * along_flat, sine * along_steep + cosine * along_flat};
    }

    /// The best shift that steps from `start` come to, and what it leaves.
    std::pair<Shift, double> refined(const std::vector<Point>& points, const Shift& start) const {
        std::pair<Shift, double> best{{}, rest(points, {})};
        Shift u = start;
        for (int i = 0; i < iterations; ++i) {
            u = improved(points, u);
            if (std::hypot(u.x - start.x, u.y - start.y) > most_refinement) {
                break;
            }
            const double now = rest(points, u);
            if (now < best.second) {
                best = {u, now};
            }
        }
        return best;
    }

private:
    double whole_rest(const std::vector<Point>& points, int ux, int uy) const {
        const Neighbour from(a_, -ux, -uy), here(b_, 0, 0);
        std::int64_t sum = 0;
        for (const Point& p : points) {
            const std::uint8_t *a = from.at(p), *b = here.at(p);
            for (int c = 0; c < 3; ++c) {
                sum += (b[c] - a[c]) * (b[c] - a[c]);
            }
        }
        return static_cast<double>(sum);
    }

    const Picture& a_;
    const Picture& b_;
};

/// The cells with their sums.
Area sum_of(std::vector<std::int32_t> cells, const DifferenceMap& map, int level) {
    Area area;
    const int columns = cell_count(map.width);
    int right = -1;
    int bottom = -1;
    area.box = {map.width, map.height, 0, 0};
    for (const std::int32_t cell : cells) {
        const int left = cell % columns * cell_size;
        const int top = cell / columns * cell_size;
        for (int y = top; y < std::min(top + cell_size, map.height); ++y) {
            for (int x = left; x < std::min(left + cell_size, map.width); ++x) {
                const int d = map.smooth[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                                      static_cast<std::size_t>(x)];
                if (d > level) {
                    ++area.pixels;
                    area.largest = std::max(area.largest, d);
                    area.box.x = std::min(area.box.x, x);
                    area.box.y = std::min(area.box.y, y);
                    right = std::max(right, x);
                    bottom = std::max(bottom, y);
                }
            }
        }
    }
    area.box.width = right - area.box.x + 1;
    area.box.height = bottom - area.box.y + 1;
    area.cells = std::move(cells);
    return area;
}

} // namespace

std::vector<Area> find_areas(const DifferenceMap& map, int level) {
    const int columns = cell_count(map.width);
    const int rows = cell_count(map.height);
    std::vector<std::int32_t> is_open = count_in_cells(map.smooth, map.width, map.height, level);
    std::vector<std::int32_t> cells; // of the area under way
    const auto add_neighbours = [&](int x, int y) {
        for (int row = std::max(y - 1, 0); row <= std::min(y + 1, rows - 1); ++row) {
            for (int column = std::max(x - 1, 0); column <= std::min(x + 1, columns - 1); ++column) {
                std::int32_t& next = is_open[static_cast<std::size_t>(row * columns + column)];
                if (next != 0) {
                    next = 0;
                    cells.push_back(row * columns + column);
                }
            }
        }
    };
    std::vector<Area> areas;
    for (std::size_t start = 0; start < is_open.size(); ++start) {
        if (is_open[start] == 0) {
            continue;
        }
        cells.assign(1, static_cast<std::int32_t>(start));
        is_open[start] = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            add_neighbours(cells[i] % columns, cells[i] / columns);
        }
        std::sort(cells.begin(), cells.end());
        areas.push_back(sum_of(std::move(cells), map, level));
    }
    std::stable_sort(areas.begin(), areas.end(), [](const Area& a, const Area& b) { return a.pixels > b.pixels; });
    return areas;
}

std::vector<Area> split_area(const Area& area, const DifferenceMap& map, int level, int side) {
    const int columns = cell_count(map.width);
    const int half = side / 2 / cell_size; // [cells]
    std::map<std::pair<int, int>, std::vector<std::int32_t>> tiles;
    for (const std::int32_t cell : area.cells) {
        const int i = cell % columns / half;
        const int j = cell / columns / half;
        for (const auto& [di, dj] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
            tiles[{j - dj, i - di}].push_back(cell);
        }
    }
    std::vector<Area> parts;
    for (auto& [place, cells] : tiles) {
        parts.push_back(sum_of(std::move(cells), map, level));
    }
    return parts;
}

namespace {

/// From a to b, the two pictures of the map.
Displacement fit_between(const Picture& a, const Picture& b, const DifferenceMap& map, const Area& area, int reach) {
    const Fit fit(a, b);
    const std::vector<Point> points = points_of(area, a.width, a.height, most_points);
    const double before = fit.rest(points, {});
    if (before == 0.0) {
        return {};
    }
    const auto is_seen = [&](const Shift& u) {
        return std::hypot(u.x, u.y) < far_shift || spread_along(map, points, u) > least_spread * std::hypot(u.x, u.y);
    };
    auto [shift, rest] = fit.refined(points, {});
    if (reach > 0 && rest > far_rest * before) {
        const Shift start = fit.whole_shift(points_of(area, a.width, a.height, most_search_points), reach);
        const auto [moved, least] = fit.refined(points, start);
        if (least < rest && is_seen(moved)) {
            shift = moved;
            rest = least;
        }
    }
    return {shift.x, shift.y, 1.0 - rest / before};
}

} // namespace

Displacement fit_displacement(const DifferenceMap& map, const Area& area, int reach) {
    return fit_between(map.reference, map.candidate, map, area, reach);
}

Displacement fit_backwards(const DifferenceMap& map, const Area& area, int reach) {
    const Displacement u = fit_between(map.candidate, map.reference, map, area, reach);
    return {-u.x, -u.y, u.explained};
}

} // namespace diff

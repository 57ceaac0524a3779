#pragma once
/// Two pictures of one size -> tier, gates and clusters.
#include "render/compare/difference.h"
#include "render/compare/picture.h"
#include "render/compare/result.h"

#include <array>
#include <limits>
#include <string>

namespace diff {

/// The conditions of tier `noise`.
enum class GateId {
    edge_shift,   ///< shift by which the edges of one window of 8 x 8 would differ as much [px]
    displacement, ///< shift of a cluster [px]
    drift,        ///< mean signed difference of all pixels, by how far it is one-sided [levels]
    block_drift,  ///< the same of one block
    lone,         ///< pixels of one window of 16 x 16, where the edges elsewhere are as they were
    stray,        ///< pixels that differ far from any edge, in the whole picture
    sharpness,    ///< by which one of the two is less sharp [%]
    text,         ///< lines of text that differ, of pictures whose files tell what is written over them
    levels,       ///< largest difference [levels]: where both are known to be drawn with the same samples
};
inline constexpr std::size_t gate_count = 9;
/// Limit of a gate that is left out.
inline constexpr double not_asked = std::numeric_limits<double>::infinity();

inline constexpr const char* default_source = "default";

/// A gate's limit and where it is from.
struct Limit {
    double value = 0.0;
    std::string source = default_source;
    bool grows = false; ///< with the noise of all edges
};

/// Of GateId. README.md in this folder has the pictures that the defaults were chosen by.
struct Limits {
    std::array<Limit, gate_count> of{
        {{0.85, default_source, true}, {0.7}, {0.22}, {0.9, default_source, true}, {7.0}, {14.0}, {12.0, default_source, true},
         {0.0}, {not_asked}}};

    bool is_lossy = false; ///< encoders have had their way with one of the pictures, see lossy_limits()

    const Limit& operator[](GateId id) const { return of[static_cast<std::size_t>(id)]; }
};

/// For pairs of films and JPEG files, where no limit was asked for: encoders blur and ring at every edge.
Limits lossy_limits(const Limits& limits, bool is_jpeg);

/// The name used in JSON and by --limit: "spot", "block drift", ...
const char* name_of(GateId id);

/// Fills tier, message, sums, gates and clusters of `frame`. The pictures have the same size. `map` is memory
/// to be used again, but for what masks hide; afterwards it has what differs (on black, if the pictures have alpha).
void judge(const Picture& reference, const Picture& candidate, const Limits& limits, DifferenceMap& map,
           Frame& frame);

} // namespace diff

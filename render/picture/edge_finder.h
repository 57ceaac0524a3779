#pragma once
/// Where the parts of a picture meet.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace render {

/// Finds the pixels of a row around which, in 3 x 3, there is more than one part.
class EdgeFinder {
public:
    explicit EdgeFinder(int width)
        : differs_across_(static_cast<std::size_t>(width) + 2), differs_along_(static_cast<std::size_t>(width) + 1),
          is_edge_(static_cast<std::size_t>(width)) {}

    /// 1 for each such pixel of the middle row, 0 for the others. The loops are written such that compilers vectorize them.
    const std::vector<std::uint8_t>& find(const std::array<const std::uint32_t*, 3>& ids) {
        const auto [below, here, above] = ids;
        const auto width = static_cast<int>(is_edge_.size());
        std::uint8_t* const across = differs_across_.data(); // one element more at both ends
        for (int x = 0; x < width; ++x) {
            across[x + 1] = (here[x] != below[x]) | (here[x] != above[x]);
        }
        std::uint8_t* const along = differs_along_.data(); // element x + 1 tells of the pixels x and x + 1
        for (int x = 0; x + 1 < width; ++x) {
            along[x + 1] = here[x] != here[x + 1];
        }
        std::uint8_t* const to = is_edge_.data();
        for (int x = 0; x < width; ++x) {
            to[x] = across[x] | across[x + 1] | across[x + 2] | along[x] | along[x + 1];
        }
        return is_edge_;
    }

private:
    std::vector<std::uint8_t> differs_across_;
    std::vector<std::uint8_t> differs_along_;
    std::vector<std::uint8_t> is_edge_;
};

} // namespace render

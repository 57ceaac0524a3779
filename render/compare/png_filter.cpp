#include "render/compare/png_filter.h"

#include <bit>

namespace diff {

namespace {

/// Eight channels at a time: vectors as g++ and clang++ have them on every processor.
using Byte8 = std::uint8_t __attribute__((vector_size(8)));
using Short8 = std::int16_t __attribute__((vector_size(16)));

template <std::size_t pixel_bytes>
Short8 load(const std::uint8_t* at) {
    std::uint64_t bytes = 0; // by shifts: a copy of three bytes would go through memory
    for (std::size_t i = 0; i < pixel_bytes; ++i) {
        bytes |= std::uint64_t{at[i]} << (8 * i);
    }
    return __builtin_convertvector(std::bit_cast<Byte8>(bytes), Short8);
}

template <std::size_t pixel_bytes>
void store(std::uint8_t* at, Short8 values) {
    const auto bytes = std::bit_cast<std::uint64_t>(__builtin_convertvector(values, Byte8)); // modulo 256
    for (std::size_t i = 0; i < pixel_bytes; ++i) {
        at[i] = static_cast<std::uint8_t>(bytes >> (8 * i));
    }
}

Short8 magnitude(Short8 x) {
    const Short8 sign = x >> 15;
    return (x ^ sign) - sign;
}

Short8 chosen(Short8 mask, Short8 a, Short8 b) {
    return (mask & a) | (~mask & b);
}

/// Of left, above and above left the one nearest to left + above - above left; ties in this order.
Short8 paeth(Short8 left, Short8 up, Short8 up_left) {
    const Short8 to_left = magnitude(up - up_left);
    const Short8 to_up = magnitude(left - up_left);
    const Short8 to_up_left = magnitude(left + up - up_left - up_left);
    const Short8 is_left = (to_left <= to_up) & (to_left <= to_up_left);
    return chosen(is_left, left, chosen(to_up <= to_up_left, up, up_left));
}

template <std::size_t pixel_bytes, typename Predict>
void undo(std::uint8_t* row, const std::uint8_t* above, std::size_t row_bytes, Predict predict) {
    Short8 left{};
    Short8 up_left{};
    const Short8 low_byte = Short8{} + 255;
    for (std::size_t i = 0; i + pixel_bytes <= row_bytes; i += pixel_bytes) {
        const Short8 up = load<pixel_bytes>(above + i);
        left = (load<pixel_bytes>(row + i) + predict(left, up, up_left)) & low_byte;
        up_left = up;
        store<pixel_bytes>(row + i, left);
    }
}

template <std::size_t pixel_bytes>
void undo(int type, std::uint8_t* row, const std::uint8_t* above, std::size_t row_bytes) {
    if (type == 1) {
        undo<pixel_bytes>(row, above, row_bytes, [](Short8 left, Short8, Short8) { return left; });
    } else if (type == 3) {
        undo<pixel_bytes>(row, above, row_bytes, [](Short8 left, Short8 up, Short8) { return (left + up) >> 1; });
    } else {
        undo<pixel_bytes>(row, above, row_bytes, paeth);
    }
}

} // namespace

bool undo_filter(int type, std::uint8_t* row, const std::uint8_t* above, std::size_t row_bytes,
                 std::size_t pixel_bytes) {
    switch (type) {
    case 0:
        return true;
    case 2:
        for (std::size_t i = 0; i < row_bytes; ++i) {
            row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
        }
        return true;
    case 1:
    case 3:
    case 4:
        switch (pixel_bytes) {
        case 1:
            undo<1>(type, row, above, row_bytes);
            return true;
        case 2:
            undo<2>(type, row, above, row_bytes);
            return true;
        case 3:
            undo<3>(type, row, above, row_bytes);
            return true;
        case 4:
            undo<4>(type, row, above, row_bytes);
            return true;
        case 6:
            undo<6>(type, row, above, row_bytes);
            return true;
        case 8:
            undo<8>(type, row, above, row_bytes);
            return true;
        default:
            return false;
        }
    default:
        return false;
    }
}

} // namespace diff

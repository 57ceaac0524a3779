#pragma once
/// What the parts of the table of all keys are written with.
#include "sim/scene/keys.h"

namespace sim::key_groups {

inline constexpr KeyRange any{};
inline constexpr KeyRange positive{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr KeyRange not_negative{0.0};
inline constexpr KeyRange unit_interval{0.0, 1.0};

inline constexpr std::string_view none; ///< may be left out

using Keys = std::vector<KeySpec>;
using enum KeyType;

/// One list made of several.
inline Keys operator+(Keys a, const Keys& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

} // namespace sim::key_groups

namespace sim {

/// view_keys.cpp has the tables of what is seen, not computed.
std::vector<SectionSpec> view_sections();
std::vector<SectionSpec> overlay_sections();

} // namespace sim

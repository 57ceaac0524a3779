/// libFuzzer: any text is a scene or a sim::Error with one line.
#include "sim/base/error.h"
#include "sim/scene/file.h"
#include "sim/scene/summary.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace {

/// A line that speaks of a count has a number of two digits: a lattice of up to a million bodies takes its time, and
/// leads nowhere that one of some hundred does not.
bool may_be_large(const std::string& text) {
    for (std::size_t at = 0; (at = text.find("count", at)) != std::string::npos; ++at) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        for (std::size_t i = at; i + 1 < end; ++i) {
            const auto is_digit = [&](std::size_t k) { return text[k] >= '0' && text[k] <= '9'; };
            if (is_digit(i) && (is_digit(i + 1) || text[i + 1] == 'e' || text[i + 1] == '_')) {
                return true;
            }
        }
    }
    return false;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    if (may_be_large(text)) {
        return 0;
    }
    try {
        const sim::SceneDef scene = sim::parse_scene(text, "fuzz.toml");
        CHECK(!sim::describe_scene(scene).empty());
    } catch (const sim::Error& error) {
        CHECK(error.code() == sim::ExitCode::usage || error.code() == sim::ExitCode::io);
    }
    return 0;
}

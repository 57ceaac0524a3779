#pragma once
/// What is written over two pictures, compared as text.
#include "render/compare/picture.h"

#include <string>
#include <vector>

namespace diff {

struct TextDifference {
    int lines = 0;      ///< that differ, or that only one of the two has; none that a mask touches
    std::string reason; ///< one sentence, with the first of them
};

/// The same words at another place are the same: pixels tell places.
TextDifference compare_texts(const std::vector<TextLine>& reference, const std::vector<TextLine>& candidate);

} // namespace diff

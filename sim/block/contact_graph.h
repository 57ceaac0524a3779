#pragma once
/// The contact graph: how many contacts a body is away from a static one.
#include "sim/block/contact_block.h"

namespace sim {

/// Level of each body [body_count]: 0 static, 1 touching a static body, ...; -1: no chain of blocks
/// leads to a static body, or it is in none.
std::vector<int> contact_levels(std::span<const ContactBlock> blocks, std::span<const BodyProps> bodies);

} // namespace sim

#include "sim/block/contact_graph.h"

#include <algorithm>
#include <utility>

namespace sim {

std::vector<int> contact_levels(std::span<const ContactBlock> blocks, std::span<const BodyProps> bodies) {
    std::vector<int> level(bodies.size(), -1);
    std::vector<std::pair<int, int>> neighbours; // of each body in a block, in the order of bodies
    std::vector<int> front;
    for (const ContactBlock& block : blocks) {
        neighbours.emplace_back(block.a, block.b);
        neighbours.emplace_back(block.b, block.a);
        for (const int body : {block.a, block.b}) {
            int& of_body = level[static_cast<std::size_t>(body)];
            if (of_body < 0 && bodies[static_cast<std::size_t>(body)].is_static()) {
                of_body = 0;
                front.push_back(body);
            }
        }
    }
    std::ranges::sort(neighbours);
    for (std::size_t next = 0; next < front.size(); ++next) {
        const int body = front[next];
        const int further = level[static_cast<std::size_t>(body)] + 1;
        auto at = std::ranges::lower_bound(neighbours, std::pair(body, 0));
        for (; at != neighbours.end() && at->first == body; ++at) {
            int& other = level[static_cast<std::size_t>(at->second)];
            if (other < 0) {
                other = further;
                front.push_back(at->second);
            }
        }
    }
    return level;
}

} // namespace sim

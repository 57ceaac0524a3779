#include "sim/contact_graph.h"

namespace sim {

std::vector<int> contact_levels(std::span<const ContactBlock> blocks, std::span<const BodyProps> bodies) {
    std::vector<int> level(bodies.size(), -1);
    std::vector<std::vector<int>> neighbours(bodies.size());
    for (const ContactBlock& block : blocks) {
        neighbours[static_cast<std::size_t>(block.a)].push_back(block.b);
        neighbours[static_cast<std::size_t>(block.b)].push_back(block.a);
    }
    std::vector<int> front;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        if (bodies[i].is_static()) {
            level[i] = 0;
            front.push_back(static_cast<int>(i));
        }
    }
    for (std::size_t next = 0; next < front.size(); ++next) {
        for (const int neighbour : neighbours[static_cast<std::size_t>(front[next])]) {
            int& other = level[static_cast<std::size_t>(neighbour)];
            if (other < 0) {
                other = level[static_cast<std::size_t>(front[next])] + 1;
                front.push_back(neighbour);
            }
        }
    }
    return level;
}

} // namespace sim

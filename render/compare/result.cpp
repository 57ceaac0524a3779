#include "render/compare/result.h"

namespace diff {

const char* name_of(Tier tier) {
    constexpr const char* names[] = {"identical", "noise", "changed"};
    return names[static_cast<int>(tier)];
}

const char* name_of(Status status) {
    constexpr const char* names[] = {"compared", "size_differs", "reference_missing", "candidate_missing",
                                     "unreadable"};
    return names[static_cast<int>(status)];
}

const char* name_of(Cause cause) {
    constexpr const char* names[] = {"unknown", "scene", "simulation", "drawing", "machine"};
    return names[static_cast<int>(cause)];
}

const char* name_of(ClusterKind kind) {
    constexpr const char* names[] = {"noise", "moved", "recoloured", "replaced"};
    return names[static_cast<int>(kind)];
}

const char* name_of(BodyChange::Kind kind) {
    constexpr const char* names[] = {"moved", "turned", "missing", "appeared", "recoloured"};
    return names[static_cast<int>(kind)];
}

} // namespace diff

#pragma once
/// Pair of bodies -> manifold: boxes, balls and planes in closed form, other convex parts by convex_pair.h.
#include "sim/collide/manifold.h"

#include <optional>

namespace sim {

struct PlacedShape {
    const Shape& shape;
    const Pose& pose;
};

/// All contacts of a pair with gap <= margin [m], ordered by feature id. a and b are the bodies' indices.
/// contacts of the result may be empty. A full face or edge manifold for box against box and box against
/// plane. known: those of the pair a little before, near which the search begins, for time only.
void find_contacts(const PlacedShape& a, const PlacedShape& b, double margin, std::vector<FoundContact>& contacts,
                   std::span<const Contact> known = {});

/// Signed distance of two shapes [m], exact where they overlap (its negative is the depth of penetration) and
/// a lower bound of the distance where they are apart. Looks at the shapes anew, without any preference among
/// features. nearest, of two convex bodies: a face of b that tells the direction along which it was found.
double separation(const PlacedShape& a, const PlacedShape& b, ContactFeature* nearest = nullptr);

/// How far two convex bodies are apart along the normal that these features have [m], no more than separation(). None where that
/// would not take far less: of boxes, balls, planes and compounds.
std::optional<double> separation_along(const PlacedShape& a, const PlacedShape& b, const ContactFeature& features);

} // namespace sim

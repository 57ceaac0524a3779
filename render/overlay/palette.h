#pragma once
/// Colours that colour-blind people can tell apart.
#include <glm/glm.hpp>

namespace render {

/// Okabe & Ito 2008, without black: display values 0..1. Index 0 and up, in turn.
glm::vec3 category_color(int index);

/// Viridis (Smith & van der Walt 2015) at 0..1: from dark blue to yellow, ever lighter. Display values.
glm::vec3 scale_color(float share);

/// Display value (sRGB) to linear light and back, component by component.
glm::vec3 linear_from_display(const glm::vec3& color);
glm::vec3 display_from_linear(const glm::vec3& color);

} // namespace render

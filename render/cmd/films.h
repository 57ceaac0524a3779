#pragma once
/// Films: how they are read and written to be compared, and what is to be said of one.
#include "render/compare/source.h"
#include "sim/model/scene_def.h"

#include <string>

namespace cmd {

diff::FilmTools film_tools();

/// What is to be known of a scene's film before it is shown: a line, or nothing.
std::string film_note(const sim::SceneDef& scene);

} // namespace cmd

#pragma once
/// Films for comparing: read by libav, written as the program's own films are.
#include "render/compare/source.h"

namespace cmd {

diff::FilmTools film_tools();

} // namespace cmd

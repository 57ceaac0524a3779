#pragma once
/// Room for a drawing before it begins.

namespace render {

/// Throws Error (stopped) if the limit of this process (ulimit -v) leaves no room to draw and encode pictures
/// of this size [px]: OpenGL in software and the encoder crash, or wait for ever, where memory is refused to
/// them.
void require_memory(int width, int height);

} // namespace render

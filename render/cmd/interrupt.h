#pragma once
/// Ctrl-C, SIGTERM and SIGHUP as a flag that threads look at.

namespace cmd {

/// From now on these signals no longer end the program at once, but after a second, if it has not ended by
/// itself; nor does a write beyond the file size limit: it fails.
void catch_interrupts();

/// True once one of them has arrived.
bool is_interrupted();

} // namespace cmd

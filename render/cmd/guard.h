#pragma once
/// What a program of the project does with errors: one line, and the exit code.
#include <functional>
#include <string>

namespace cmd {

/// The arguments as one text.
std::string command_line(int argc, char** argv);

/// Catches interrupts, runs `program` and returns its exit code, or that of the Error it throws. A reader of standard output
/// that has gone is no error.
int guarded(const std::function<int()>& program);

} // namespace cmd

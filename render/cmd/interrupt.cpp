#include "render/cmd/interrupt.h"

#include "sim/base/error.h"

#include <csignal>
#include <initializer_list>
#include <string_view>
#include <unistd.h>

namespace cmd {

namespace {

// A signal handler can reach nothing but a variable of this kind.
volatile std::sig_atomic_t signal_arrived = 0;

// What does not look at the flag, such as a read from a pipe that nobody writes, is ended after this long
// [s].
constexpr unsigned patience = 1;

extern "C" void remember_signal(int) {
    if (signal_arrived == 0) {
        ::alarm(patience);
    }
    signal_arrived = 1;
}

extern "C" void end_program(int) {
    constexpr std::string_view line = "tumble: interrupted\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
    ::_exit(static_cast<int>(sim::ExitCode::interrupted));
}

} // namespace

void catch_interrupts() {
    struct sigaction action {};
    action.sa_handler = remember_signal;
    action.sa_flags = SA_RESTART; // system calls of the writing threads go on
    sigemptyset(&action.sa_mask);
    for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
        sigaction(signal_number, &action, nullptr);
    }
    action.sa_handler = end_program;
    sigaction(SIGALRM, &action, nullptr);
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN); // a reader that has gone is an error of writing
}

bool is_interrupted() {
    return signal_arrived != 0;
}

} // namespace cmd

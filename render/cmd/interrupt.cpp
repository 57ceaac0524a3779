#include "render/cmd/interrupt.h"

#include <csignal>
#include <initializer_list>

namespace cmd {

namespace {

// A signal handler can reach nothing but a variable of this kind.
volatile std::sig_atomic_t signal_arrived = 0;

extern "C" void remember_signal(int) {
    signal_arrived = 1;
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
    std::signal(SIGXFSZ, SIG_IGN);
}

bool is_interrupted() {
    return signal_arrived != 0;
}

} // namespace cmd

// A system call in every thread of the process.
#pragma once

namespace pxpl5::host::io {

/// Runs `act` once in every thread of this process. Threads of libraries take part, although they
/// block signals. No other call of this function may run at the same time.
///
/// act     Runs in a signal handler, so it may only make system calls. Returns false on failure.
/// Throws  std::runtime_error if `act` failed in a thread, or a thread did not answer within 5 s.
void in_every_thread(bool (*act)());

}  // namespace pxpl5::host::io

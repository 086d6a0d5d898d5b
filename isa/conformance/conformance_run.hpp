// Brings an executor into a conformance case's state, runs the case and compares.
#pragma once

#include <string>

#include "isa/conformance/conformance_file.hpp"
#include "isa/executor.hpp"

namespace pxpl5::isa {

/// The pixels that the case compares: its watched ones, or all.
std::vector<PixelRectangle> compared_pixels(const ConformanceCase& test);

/// Brings the pixels of `executor`, which is as new, into the state of `given`. It is done by
/// programs, so that every executor can be brought there; they use SETENABS, CLRENABS, MEMintoENAB,
/// the TREE and QUAD rows that test and store, CONSTintoMEM, CLEARMEM, MEMpluseqMEM and BSWRITE.
/// Throws std::invalid_argument if enables differ from pixel to pixel and the fields given leave no
/// bit of memory free.
void set_up(const std::vector<StateTable>& given, Executor& executor);

/// Sets `executor`, which is as new, up, runs the program and compares the pixels of `area` that
/// the case watches, then what the controller tells. Returns the first difference as a sentence
/// that names what, where and both values; empty if there is none.
/// before_run  Called between set-up and run, for tests that plant a fault.
std::string first_difference(const ConformanceCase& test, Executor& executor,
                             const PixelRectangle& area = {},
                             const std::function<void()>& before_run = {});

}  // namespace pxpl5::isa

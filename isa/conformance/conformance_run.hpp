// Runs an executor through a conformance case.
#pragma once

#include <string>

#include "isa/conformance/conformance_file.hpp"
#include "isa/executor.hpp"

namespace pxpl5::isa {

/// Returns the pixels that the case compares: the watched pixels, or all.
std::vector<PixelRectangle> compared_pixels(const ConformanceCase& test);

/// Puts the pixels of a new `executor` into the state of `given`. Works on every executor, because
/// it runs a program: SETENABS, CLRENABS, MEMintoENAB, the TREE and QUAD rows that test and store,
/// CONSTintoMEM, CLEARMEM, MEMpluseqMEM, BSWRITE and BSWAIT.
/// Throws std::invalid_argument if the enable bits of the pixels differ and the given fields leave
/// no bit of memory free.
void set_up(const std::vector<StateTable>& given, Executor& executor);

/// Puts a new `executor` into the given state and runs the program. Then compares the watched
/// pixels in `area` and the results of the controller. Returns the first difference as a sentence
/// that names the item, the place and both values, or an empty text. before_run  Called between
/// set-up and run, for tests that plant a fault.
std::string first_difference(const ConformanceCase& test, Executor& executor,
                             const PixelRectangle& area = {},
                             const std::function<void()>& before_run = {});

}  // namespace pxpl5::isa

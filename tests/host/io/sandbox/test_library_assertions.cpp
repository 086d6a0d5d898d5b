// Assertions of libraries, in a program that takes the place of the C library's __assert_fail.
#include <doctest/doctest.h>
#include <gdcmBitmap.h>

#include <cassert>
#include <csignal>
#include <string>

#include "host/io/library_assertions.hpp"
#include "host/io/values/file_at_work.hpp"
#include "tests/host/io/sandbox/confined.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

TEST_CASE("an assertion inside a library ends the process as bad data, with the file's name") {
    const Ending ending = in_child([] {
        std::signal(SIGABRT, SIG_DFL);  // Not doctest's.
        const std::string file = "scan/x.dcm";
        const FileAtWork at_work(file);
        gdcm::Bitmap().SetNumberOfDimensions(7);
        return 0;
    });
    CHECK(ending.signal == 0);
    CHECK(ending.code == 65);
    CHECK_MESSAGE(ending.log.find("scan/x.dcm: the DICOM library (GDCM) refuses this file: its "
                                  "check 'NumberOfDimensions == 2 || NumberOfDimensions == 3' "
                                  "fails (gdcmBitmap.cxx:") == 0,
                  ending.log);
    CHECK(ending.log.find('\n') == ending.log.size() - 1);
}

TEST_CASE("an assertion of this program still aborts, and blames no file") {
    const Ending ending = in_child([] {
        std::signal(SIGABRT, SIG_DFL);
        const volatile int one = 1;
        assert(one == 2);
        return 0;
    });
    CHECK(ending.signal == SIGABRT);
    CHECK_MESSAGE(ending.log.find("Assertion `one == 2' failed.") != std::string::npos, ending.log);
}

TEST_CASE("the text of a refusal names a library that is not GDCM, and the file only if known") {
    const Assertion other{"a > 0", "/usr/include/glm/vec.hpp", 12};
    CHECK(refusal_of(other, nullptr)
              .find("a library refuses this file: its check 'a > 0' fails "
                    "(vec.hpp:12). The file may be damaged") == 0);
    CHECK(!is_own(other));
    const std::string outer = "outer", inner = "inner";
    const FileAtWork first(outer);
    {
        const FileAtWork second(inner);
        CHECK(file_at_work.load() == inner);
    }
    CHECK(file_at_work.load() == outer);
}

// The entry that libFuzzer calls.
#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    pxpl5::fuzz::accepts({data, size});
    return 0;
}

// Made by pxpl5 trace shrink: 10 instructions of 684.
// from frame 0, region 0 of a run of a wrong Renderer
#include <doctest/doctest.h>

#include "isa/assemble.hpp"
#include "isa/sequencer.hpp"
#include "tests/isa/lockstep.hpp"
#include "tests/renderer_firmware/targets.hpp"

TEST_CASE("reference and fast leave the same") {
    using namespace pxpl5;
    const std::vector<std::uint32_t> words = isa::assemble(R"(
        SETENABS
        TREEgeZERO :16  64 -1 -3891
        TREEgeZERO :16  -64 14 2258
        TREEgeZERO :16  0 0 0
        TREEltMEM m8:24 >>8  0 0 0
        TREEintoMEM m8:24 >>8  0 0 0
        TREEintoMEM m32:10 >>16  0 0 0
        TREEintoMEM m42:10 >>16  0 0 0
        TREEintoMEM m52:10 >>16  0 0 0
        IMMintoMEM m0:8 #0
)")
                                                 .bind({});
    test::on_every_target([&](renderer::fast::Fast& fast) {
        isa::reference::Reference reference;
        test::Lockstep both(reference, fast);
        isa::Controller trusted, tested;
        isa::run(words, reference, trusted);
        isa::run(words, fast, tested);
        CHECK_NOTHROW(both.compare_all("at the end"));
    });
}

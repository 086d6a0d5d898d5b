// Runs both executors through the conformance cases, and tests the cases with wrong executors.
#include <doctest/doctest.h>

#include <map>
#include <ranges>
#include <set>

#include "isa/disassemble.hpp"
#include "isa/sequencer.hpp"
#include "tests/isa/conformance_suite.hpp"
#include "tests/isa/coverage.hpp"
#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using isa::Op;
using renderer::fast::Fast;
using renderer::fast::Target;
using test::conformance_suite;
using test::ConformanceFile;

namespace {

/// Runs the instructions of an executor one by one. Skips one row after drop().
class OneByOne final : public isa::Executor {
  public:
    explicit OneByOne(isa::Executor& inner) : inner_(inner) {
        inner_.set_readout([this](auto pixels) { read_out(pixels); });
    }
    OneByOne(const OneByOne&) = delete;
    OneByOne& operator=(const OneByOne&) = delete;
    ~OneByOne() { inner_.set_readout({}); }

    void drop(Op op) { dropped_ = op; }
    void execute(isa::Instruction in, isa::Coefficients coefficients) override {
        if (in.op != dropped_) {
            inner_.execute(in, coefficients);
        }
    }
    bool any_enabled() const override { return inner_.any_enabled(); }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override {
        return inner_.field(x, y, a, n);
    }
    bool enabled(int x, int y) const override { return inner_.enabled(x, y); }
    bool carry(int x, int y) const override { return inner_.carry(x, y); }
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override {
        return inner_.backing_block(x, y, block);
    }

  private:
    isa::Executor& inner_;
    std::optional<Op> dropped_;
};

/// Returns the first failure of a case that names `op`, with the name of the case.
template <typename Difference>
std::string a_failure(Op op, const Difference& difference) {
    // Generated cases, which are last by name, watch few pixels.
    for (const ConformanceFile& file : std::views::reverse(conformance_suite())) {
        if (file.names(op)) {
            if (const std::string found = difference(file); !found.empty()) {
                return file.name + ": " + found;
            }
        }
    }
    return {};
}

/// Returns the case with all instructions of a control row disabled: replaced by NOP, or by a loop
/// of one round. A NOP is replaced by an instruction with an effect.
isa::ConformanceCase without_control(isa::ConformanceCase test, Op op) {
    std::vector<std::uint32_t>& words = test.program.words;
    const std::uint32_t nop = isa::encode({Op::nop, {}});
    for (std::size_t at = 0; at < words.size();) {
        const std::size_t count = isa::instruction_words(words[at]);
        if (isa::decode(words[at])->op == op) {
            words[at] = op == Op::loop  ? isa::encode({Op::loop, {0, 1, 0}})
                        : op == Op::nop ? isa::encode({Op::any_enab, {}})
                                        : nop;
            std::fill_n(words.begin() + static_cast<std::ptrdiff_t>(at) + 1, count - 1, nop);
        }
        at += count;
    }
    return test;
}

/// True if `instead` can replace `row`: both take the same operands and coefficients. Excludes the
/// readout row, which runs for all pixels at once.
bool can_stand_in(const isa::OpInfo& instead, const isa::OpInfo& row) {
    return instead.words == row.words && instead.n_max >= row.n_max &&
           (instead.n_max == 0) == (row.n_max == 0) && instead.b_role == row.b_role &&
           instead.pattern.a.mask == row.pattern.a.mask &&
           ((instead.effects | row.effects) & isa::port) == 0 && !instead.is_control() &&
           !row.is_control();
}

}  // namespace

TEST_CASE("every conformance case holds on the reference") {
    CHECK(conformance_suite().size() >= 300);
    for (const ConformanceFile& file : conformance_suite()) {
        const std::string found = test::difference_on_reference(file);
        CHECK_MESSAGE(found.empty(), file.name, ": ", found);
    }
}

TEST_CASE("every conformance case holds on the fast executor, on every target") {
    test::on_every_target([](Fast& fast) {
        for (const ConformanceFile& file : conformance_suite()) {
            fast.reset();
            const std::string found = first_difference(file.test, fast);
            CHECK_MESSAGE(found.empty(), file.name, ": ", found);
        }
    });
}

TEST_CASE("every conformance case holds on the fast executor, instruction by instruction") {
    Fast fast;
    OneByOne steps(fast);
    for (const ConformanceFile& file : conformance_suite()) {
        fast.reset();
        const std::string found = first_difference(file.test, steps);
        CHECK_MESSAGE(found.empty(), file.name, ": ", found);
    }
}

TEST_CASE("conformance cases meet every row, width, state of the enables and edge of the region") {
    for (const std::string& cell : test::open_cells(test::coverage_of_suite())) {
        FAIL_CHECK(cell);
    }
}

TEST_CASE("every conformance case has a title of its own") {
    std::map<std::string, std::string> name_of_title;
    for (const ConformanceFile& file : conformance_suite()) {
        CHECK_MESSAGE(!file.test.title.empty(), file.name, " has no title");
        const auto [other, is_new] = name_of_title.emplace(file.test.title, file.name);
        CHECK_MESSAGE(is_new, file.name, " and ", other->second, " have one title");
    }
}

TEST_CASE("a row that does nothing to pixels fails a conformance case that names it") {
    Fast fast;
    for (std::size_t i = 0; i < isa::op_count; ++i) {
        const Op op = static_cast<Op>(i);
        if (isa::info(op).is_control()) {
            continue;
        }
        const std::string found = a_failure(op, [&](const ConformanceFile& file) {
            fast.reset();
            OneByOne steps(fast);
            return first_difference(file.test, steps, {}, [&] { steps.drop(op); });
        });
        CHECK_MESSAGE(!found.empty(), isa::info(op).name, " may do nothing, and no case fails");
        CHECK_MESSAGE(found.find("before the run") == std::string::npos, found);
    }
}

TEST_CASE("a generated case fails if its row does nothing, unless one bit leaves nothing to do") {
    // A bit is its own absolute value, negative and square root.
    const std::set<std::string> nothing_to_do = {"ABSMEM_n1", "NEGMEM_n1", "SQRTMEM_n1"};
    Fast fast;
    std::size_t cases = 0;
    for (const ConformanceFile& file : conformance_suite()) {
        const std::string stem = std::filesystem::path(file.name).stem().string();
        const std::string name = stem.substr(0, stem.find('_'));
        const auto row = std::ranges::find(isa::op_table, name, &isa::OpInfo::name);
        if (row == isa::op_table.end() || row->is_control()) {
            continue;
        }
        fast.reset();
        OneByOne steps(fast);
        const auto drop = [&] { steps.drop(static_cast<Op>(row - isa::op_table.begin())); };
        const bool fails = !first_difference(file.test, steps, {}, drop).empty();
        CHECK_MESSAGE(
            fails != nothing_to_do.contains(stem.substr(0, stem.find('_', name.size() + 1))),
            file.name);
        ++cases;
    }
    CHECK(cases > 400);
}

TEST_CASE("a row of the controller that does nothing fails a conformance case that names it") {
    Fast fast;
    for (std::size_t i = 0; i < isa::op_count; ++i) {
        const Op op = static_cast<Op>(i);
        if (!isa::info(op).is_control() || op == Op::end_loop) {
            continue;  // A program without its ENDLOOP is invalid; LOOP tests both.
        }
        const std::string found = a_failure(op, [&](const ConformanceFile& file) {
            fast.reset();
            return first_difference(without_control(file.test, op), fast);
        });
        CHECK_MESSAGE(!found.empty(), isa::info(op).name, " may do nothing, and no case fails");
    }
}

TEST_CASE("a row that does what another row does fails a conformance case that names it") {
    const renderer::fast::Backend& right = renderer::fast::backend(Target::best);
    std::size_t pairs = 0;
    for (std::size_t victim = 0; victim < isa::op_count; ++victim) {
        for (std::size_t other = 0; other < isa::op_count; ++other) {
            const isa::OpInfo &row = isa::op_table[victim], &instead = isa::op_table[other];
            if (victim == other || !can_stand_in(instead, row)) {
                continue;
            }
            renderer::fast::Backend wrong = right;
            const auto plant = [&] { wrong.handlers[victim] = right.handlers[other]; };
            const auto mend = [&] { wrong.handlers[victim] = right.handlers[victim]; };
            const std::string found =
                a_failure(static_cast<Op>(victim), [&](const ConformanceFile& file) {
                    Fast fast(wrong);
                    std::string difference = first_difference(file.test, fast, {}, plant);
                    mend();
                    return difference;
                });
            CHECK_MESSAGE(!found.empty(), row.name, " may do what ", instead.name, " does");
            ++pairs;
        }
    }
    CHECK(pairs > 250);
}

TEST_CASE("a quadratic row that leaves its squares out fails a conformance case that names it") {
    const renderer::fast::Backend& right = renderer::fast::backend(Target::best);
    for (std::size_t i = 0; i < isa::op_count; ++i) {
        if (isa::op_table[i].words != 6) {
            continue;
        }
        // The linear rows are eight before the quadratic ones.
        const std::size_t linear = i - 8;
        REQUIRE(isa::op_table[linear].effects == isa::op_table[i].effects);
        renderer::fast::Backend wrong = right;
        const std::string found = a_failure(static_cast<Op>(i), [&](const ConformanceFile& file) {
            Fast fast(wrong);
            std::string difference = first_difference(
                file.test, fast, {}, [&] { wrong.handlers[i] = right.handlers[linear]; });
            wrong.handlers[i] = right.handlers[i];
            return difference;
        });
        CHECK_MESSAGE(!found.empty(), isa::op_table[i].name);
    }
}

// The main of each test program: doctest's, and a filter that chooses no test case is a failure.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>

namespace {

/// Counts the test cases that the filters have chosen.
struct Chosen final : doctest::IReporter {
    explicit Chosen(const doctest::ContextOptions&) {}
    void report_query(const doctest::QueryData&) override {}
    void test_run_start() override {}
    void test_run_end(const doctest::TestRunStats& run) override {
        count = run.numTestCasesPassingFilters;
    }
    void test_case_start(const doctest::TestCaseData&) override {}
    void test_case_reenter(const doctest::TestCaseData&) override {}
    void test_case_end(const doctest::CurrentTestCaseStats&) override {}
    void test_case_exception(const doctest::TestCaseException&) override {}
    void subcase_start(const doctest::SubcaseSignature&) override {}
    void subcase_end() override {}
    void log_assert(const doctest::AssertData&) override {}
    void log_message(const doctest::MessageData&) override {}
    void test_case_skipped(const doctest::TestCaseData&) override {}

    static inline unsigned count = 0;
};
REGISTER_LISTENER("chosen", 1, Chosen);

}  // namespace

int main(int argc, char** argv) {
    doctest::Context context(argc, argv);
    const int result = context.run();
    if (context.shouldExit()) {  // It only listed the test cases.
        return result;
    }
    if (result == 0 && Chosen::count == 0) {
        std::fprintf(stderr,
                     "no test case has the name that the filter asks for; "
                     "CTest takes names with a semicolon apart\n");
        return 1;
    }
    return result;
}

// The job that `serve` submits: its script, the options of sbatch, and what Slurm says about it.
#include <doctest/doctest.h>

#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/kernel/run_program.hpp"
#include "host/serve/job/job.hpp"
#include "host/serve/job/job_script.hpp"
#include "host/serve/job/job_state.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::serve;

namespace {

constexpr int limit_ms = 60'000;

/// The words that the script of a job hands to its program.
std::string words_in_script(std::vector<std::string> words) {
    std::string script = job_script({std::move(words), 0, {}}, "/bin/echo");
    const std::size_t program = script.find("exec \"$program\"");
    REQUIRE(program != std::string::npos);
    script.replace(program, std::string::npos, "printf '<%s>' \"$PXPL5\" \"$@\"\n");
    const std::size_t folder = script.find("mkdir -p");  // The test leaves no folder.
    REQUIRE(folder != std::string::npos);
    script.replace(folder, script.find('\n', folder) - folder, "SLURM_JOB_ID=1");
    const ProgramEnd end = run_program({"bash"}, script, limit_ms);
    CHECK(end.errors == "");
    return end.out.substr(end.out.find('<'));
}

JobState state_of(const std::string& name, const std::string& more) {
    return parse_job_state("JobId=7 JobName=pxpl5\n   JobState=" + name + " " + more +
                           "\n   ReqNodeList=n9 NodeList=n[1-2]\n   StdOut=/home/a b/x.out\n");
}

}  // namespace

TEST_CASE("the script hands the user's words to the program, whatever a shell would read") {
    CHECK(words_in_script({"a b.nii", "--surface", "bone='250',$HOME", "; rm *"}) ==
          "</bin/echo><a b.nii><--surface><bone='250',$HOME><; rm *>");
    CHECK(words_in_script({}) == "</bin/echo>");
}

TEST_CASE("the program in the job does not get the options for the job") {
    CHECK(words_in_script({"--nodes", "3", "scan.nii", "--time-limit=90", "--engine=slurm",
                           "--sbatch-option=--account=a", "--sbatch-option", "-pgpu", "--port",
                           "80", "--", "--nodes"}) ==
          "</bin/echo><scan.nii><--port><80><--><--nodes>");
}

TEST_CASE("the script keeps what it says to sbatch, and where the addresses go") {
    const std::string script = job_script({{"x"}, 0, {}}, "/p");
    CHECK(script.starts_with("#!/bin/bash\n"));
    CHECK(script.find("\n#SBATCH --signal=B:USR1@120\n") < script.find("\nset "));
    CHECK(script.find("umask 077\n") != std::string::npos);
    CHECK(script.ends_with("serve --engine slurm \"$@\" >\"$file\"\n"));
}

TEST_CASE("sbatch gets computers, time and the user's own options, in this order") {
    CHECK(sbatch_words({{}, 3, {"--partition=gpu", "-Aphysics"}}, "1-12") ==
          std::vector<std::string>{"sbatch", "--parsable", "--nodes=3", "--time=1-12",
                                   "--partition=gpu", "-Aphysics"});
    CHECK(sbatch_words({}, "") == std::vector<std::string>{"sbatch", "--parsable"});
    CHECK_THROWS_WITH_AS(sbatch_words({{}, 0, {"partition=gpu"}}, ""),
                         doctest::Contains("--sbatch-option 'partition=gpu' is no option"),
                         RequestError);
}

TEST_CASE("sbatch prints the job in its last line, and Slurm is asked about that job") {
    using Words = std::vector<std::string>;
    const auto words = [](const std::string& printed) {
        const std::optional<SubmittedJob> job = parse_submitted(printed);
        return job ? slurm_words(*job, {"scontrol", "show", "job"}) : Words{};
    };
    CHECK(words("12\n") == Words{"scontrol", "show", "job", "12"});
    CHECK(words("Welcome to Site; 3 jobs\n 7\n12;far-1\n \n") ==
          Words{"scontrol", "-M", "far-1", "show", "job", "12"});
    for (const char* wrong : {"", "\n", "12;", "Submitted batch job 12\n", "12 13\n", ";far\n",
                              "12;-a\n", "12;a b\n", "12\ndone\n"}) {
        CAPTURE(wrong);
        CHECK(words(wrong).empty());
    }
}

TEST_CASE("a job waits, runs or has ended") {
    using enum JobState::Phase;
    const JobState waiting =
        state_of("PENDING", "Reason=Resources Dependency=(null)\n   StartTime=2026-11-25T09:00:00");
    CHECK(waiting.phase == waits);
    CHECK(waiting.computers == "n[1-2]");
    CHECK(waiting.output == "/home/a b/x.out");
    CHECK(sentence_of(waiting) ==
          "waits: Resources (the computers that it needs are in use). Expected start: "
          "2026-11-25T09:00:00");
    CHECK(sentence_of(state_of("PENDING", "Reason=None StartTime=Unknown")) == "waits");
    CHECK(sentence_of(state_of("PENDING", "Reason=AssocGrpCpuLimit")) == "waits: AssocGrpCpuLimit");
    CHECK(sentence_of(state_of("CONFIGURING", "Reason=None")) == "waits, CONFIGURING");
    CHECK(state_of("RUNNING", "Reason=None").phase == runs);
    CHECK(sentence_of(state_of("RUNNING", "")) == "runs on n[1-2]");
    CHECK(sentence_of(state_of("SUSPENDED", "")) == "is SUSPENDED on n[1-2]");
    CHECK(sentence_of(state_of("COMPLETING", "")) == "ends on n[1-2]");
    CHECK(state_of("FAILED", "Reason=NonZeroExitCode").phase == has_ended);
    CHECK(sentence_of(state_of("FAILED", "")) == "has ended: FAILED");
    CHECK(state_of("STOPPED", "").phase == runs);
    CHECK(state_of("SOMETHING_NEW", "").phase == runs);
    CHECK(sentence_of(state_of("SOMETHING_NEW", "")) == "is SOMETHING_NEW on n[1-2]");
    for (const char* end : {"BOOT_FAIL", "CANCELLED", "COMPLETED", "DEADLINE", "NODE_FAIL",
                            "OUT_OF_MEMORY", "PREEMPTED", "TIMEOUT", "REVOKED"}) {
        CAPTURE(end);
        CHECK(state_of(end, "").phase == has_ended);
    }
    CHECK(parse_job_state("").phase == has_ended);
    CHECK(sentence_of(parse_job_state("")) == "has ended: unknown to Slurm");
}

TEST_CASE("serve submits itself outside of a job, unless its computers are named or counted") {
    unsetenv("SLURM_JOB_ID");
    const JobOptions with_nodes{{}, 2, {}};
    ClusterSettings cluster;
    CHECK_FALSE(is_submitted({}, cluster));
    CHECK_THROWS_WITH_AS(is_submitted(with_nodes, cluster), doctest::Contains("engine is local"),
                         RequestError);
    cluster.engine = Engine::slurm;
    CHECK(is_submitted({}, cluster));
    CHECK(is_submitted(with_nodes, cluster));
    cluster.wait = 2;
    CHECK_FALSE(is_submitted({}, cluster));
    CHECK_THROWS_WITH_AS(is_submitted(with_nodes, cluster), doctest::Contains("--computers or"),
                         RequestError);
    cluster.wait = 0;
    setenv("SLURM_JOB_ID", "12", 1);
    CHECK_FALSE(is_submitted({}, cluster));
    CHECK_THROWS_WITH_AS(is_submitted({{}, 0, {"-pgpu"}}, cluster),
                         doctest::Contains("this is job 12 already"), RequestError);
    unsetenv("SLURM_JOB_ID");
}

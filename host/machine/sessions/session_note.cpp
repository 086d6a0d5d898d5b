#include "host/machine/sessions/session_note.hpp"

#include <nlohmann/json.hpp>
#include <system_error>
#include <tuple>
#include <utility>

#include "host/base/error.hpp"
#include "host/machine/run_folder.hpp"
#include "host/machine/sessions/json_values.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

auto values_of(const SessionFacts& facts) {
    return std::tie(facts.volume, facts.url, facts.watch_url, facts.tunnel, facts.viewers,
                    facts.ends_at, facts.saved, facts.is_ending);
}

}  // namespace

SessionNote::SessionNote(const fs::path& run_folder) : file_(run_folder / note_name) {}

SessionNote::~SessionNote() {
    SessionFacts last;
    last.volume = facts_.volume;
    last.saved = facts_.saved;
    last.is_ending = true;
    set(last);
}

void SessionNote::set(const SessionFacts& facts) {
    if (values_of(facts) == values_of(facts_)) {
        return;
    }
    facts_ = facts;
    const std::string text =
        nlohmann::ordered_json{{"volume", facts.volume},       {"url", facts.url},
                               {"watch_url", facts.watch_url}, {"tunnel", facts.tunnel},
                               {"viewers", facts.viewers},     {"ends_at", facts.ends_at},
                               {"saved", facts.saved},         {"ending", facts.is_ending}}
            .dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
    fs::path part = file_;
    part += ".part";
    std::error_code ignored;
    try {
        write_private_file(part, text + "\n");
        fs::rename(part, file_, ignored);  // Readers see the old file or the new one.
    } catch (const RequestError&) {
        // The listing shows the facts from before.
    }
    fs::remove(part, ignored);
}

SessionFacts read_note(const fs::path& run_folder) {
    const nlohmann::json read = read_json(run_folder / note_name);
    SessionFacts facts;
    facts.volume = text_in(read, "volume");
    facts.url = text_in(read, "url");
    facts.watch_url = text_in(read, "watch_url");
    facts.tunnel = text_in(read, "tunnel");
    facts.viewers = number_in(read, "viewers");
    facts.ends_at = text_in(read, "ends_at");
    facts.saved = text_in(read, "saved");
    facts.is_ending = read.is_object() && read.value("ending", nlohmann::json()) == true;
    return facts;
}

}  // namespace pxpl5::host

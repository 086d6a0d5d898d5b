#include "host/serve/classroom/classroom.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "host/serve/server/server_access.hpp"
#include "host/serve/texts/class_texts.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr int again_when_full_s = 15, again_while_starting_s = 1;
constexpr std::size_t max_waiting = 1000;

/// The port and the token of "http://[::1]:4711/?token=T".
std::pair<int, std::string> place_in(const std::string& url) {
    constexpr std::string_view middle = "/?token=";
    const std::size_t token = url.rfind(middle);
    if (token == std::string::npos) {
        return {};
    }
    const std::size_t colon = url.rfind(':', token);
    const int port = last_port_in(fmt::format("/{}/", url.substr(colon + 1, token - colon - 1)));
    return {port, url.substr(token + middle.size())};
}

PageAnswer starting(std::string_view sentence) {
    return {200, {class_text::starts}, {sentence}, again_while_starting_s};
}

}  // namespace

Classroom::Classroom(int places, std::function<void()> wake)
    : places_(places), wake_(std::move(wake)) {}

PageAnswer Classroom::answer_known(const std::function<bool(const std::string&)>& has_shown) {
    const std::lock_guard lock(mutex_);
    const auto shown = [&](const auto& each) {
        return !each.secret.empty() && has_shown(each.secret);
    };
    if (const auto entry = std::ranges::find_if(entries_, shown); entry != entries_.end()) {
        PageAnswer answer = starting(class_text::starting);
        answer.port = entry->port;
        answer.token = entry->token;
        return answer;
    }
    const auto waiting = std::ranges::find_if(waiting_, shown);
    if (waiting == waiting_.end()) {
        return {0, {}, {}};
    }
    if (!waiting->why.empty()) {
        PageAnswer answer{200, {class_text::has_ended}, {class_text::begin_anew}};
        answer.why = std::exchange(waiting->why, "");
        return answer;
    }
    return begin(std::string(waiting->secret));
}

PageAnswer Classroom::answer_new() {
    const std::lock_guard lock(mutex_);
    PageAnswer answer = starting(class_text::first_start);
    answer.secret = random_token();
    add_waiting({answer.secret, ""});
    return answer;
}

void Classroom::add_waiting(Waiting waiting) {
    waiting_.push_back(std::move(waiting));
    if (waiting_.size() > max_waiting) {
        waiting_.erase(waiting_.begin());
    }
}

PageAnswer Classroom::begin(const std::string& secret) {
    const auto ahead =
        std::ranges::find_if(entries_, [](const Entry& each) { return each.secret.empty(); });
    if (ahead != entries_.end()) {
        ahead->secret = secret;
    } else if (std::ssize(entries_) < places_) {
        add_entry(secret);
    } else {
        return {503,
                places_ == 1 ? Text{class_text::one_is_taken}
                             : Text{class_text::all_are_taken, {std::to_string(places_)}},
                {class_text::asks_again, {std::to_string(again_when_full_s)}},
                again_when_full_s};
    }
    std::erase_if(waiting_, [&](const Waiting& each) { return each.secret == secret; });
    return starting(class_text::starting);
}

void Classroom::add_entry(const std::string& secret) {
    entries_.push_back({{++last_number_, next_place()}, secret});
    wake_();
}

/// The free place that was used longest ago: its port may be taken by another program.
int Classroom::next_place() {
    const auto is_taken = [&] {
        return std::ranges::any_of(
            entries_, [&](const Entry& each) { return each.session.place == last_place_; });
    };
    do {
        last_place_ = last_place_ % places_ + 1;
    } while (is_taken());
    return last_place_;
}

bool Classroom::has_port(int port) {
    const std::lock_guard lock(mutex_);
    return port != 0 &&
           std::ranges::any_of(entries_, [&](const Entry& each) { return each.port == port; });
}

void Classroom::fail() {
    has_failed_ = true;
    wake_();
}

void Classroom::want_one() {
    const std::lock_guard lock(mutex_);
    add_entry("");
}

std::vector<WantedSession> Classroom::take_wanted() {
    const std::lock_guard lock(mutex_);
    std::vector<WantedSession> wanted;
    for (Entry& entry : entries_) {
        if (std::exchange(entry.is_wanted, false)) {
            wanted.push_back(entry.session);
        }
    }
    return wanted;
}

void Classroom::ready(int number, const std::string& url) {
    const std::lock_guard lock(mutex_);
    for (Entry& entry : entries_) {
        if (entry.session.number == number) {
            std::tie(entry.port, entry.token) = place_in(url);
        }
    }
}

void Classroom::ended(int number, const std::string& why) {
    const std::lock_guard lock(mutex_);
    const auto entry = std::ranges::find_if(
        entries_, [&](const Entry& each) { return each.session.number == number; });
    if (entry == entries_.end()) {
        return;
    }
    if (!entry->secret.empty()) {
        add_waiting({entry->secret, why});
    }
    entries_.erase(entry);
}

int Classroom::taken() const {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(
        std::ranges::count_if(entries_, [](const Entry& each) { return !each.secret.empty(); }));
}

}  // namespace pxpl5::host::serve

#include "host/serve/classroom/classroom.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "host/serve/server/server_access.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr int again_when_full_s = 15, again_while_starting_s = 1;
constexpr std::size_t max_guests = 1000;

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

}  // namespace

Classroom::Classroom(int places, std::function<SessionFacts(pid_t)> facts_of,
                     std::function<void()> wake)
    : places_(places), facts_of_(std::move(facts_of)), wake_(std::move(wake)) {}

Greeting Classroom::look(Seat& seat) const {
    if (seat.port == 0 && seat.pid != 0) {
        std::tie(seat.port, seat.token) = place_in(facts_of_(seat.pid).url);
    }
    if (seat.port != 0) {
        Greeting greeting;
        greeting.port = seat.port;
        greeting.token = seat.token;
        return greeting;
    }
    return {200, "Your session starts", "This page shows it as soon as the volume is open.",
            again_while_starting_s};
}

Greeting Classroom::greet_known(const std::function<bool(const std::string&)>& has_shown) {
    const std::lock_guard lock(mutex_);
    const auto shown = [&](const auto& each) { return has_shown(each.secret); };
    if (const auto seat = std::ranges::find_if(seats_, shown); seat != seats_.end()) {
        return look(*seat);
    }
    const auto guest = std::ranges::find_if(guests_, shown);
    if (guest == guests_.end()) {
        return {0, "", ""};
    }
    if (!guest->why.empty()) {
        return {200, "Your session has ended",
                std::exchange(guest->why, "") + " Reload this page to begin a new one."};
    }
    return begin(std::string(guest->secret));
}

Greeting Classroom::greet_new() {
    const std::lock_guard lock(mutex_);
    welcome({random_token(), ""});
    Greeting greeting{200, "Your session starts",
                      "This page shows it as soon as the volume is open. It needs cookies.",
                      again_while_starting_s};
    greeting.secret = guests_.back().secret;
    return greeting;
}

void Classroom::welcome(Guest guest) {
    guests_.push_back(std::move(guest));
    if (guests_.size() > max_guests) {
        guests_.erase(guests_.begin());
    }
}

Greeting Classroom::begin(const std::string& secret) {
    if (std::ssize(seats_) >= places_) {
        return {503,
                places_ == 1 ? "The only session is taken"
                             : fmt::format("All {} sessions are taken", places_),
                fmt::format("This page asks again every {} seconds, and opens your session as "
                            "soon as another one has ended.",
                            again_when_full_s),
                again_when_full_s};
    }
    std::erase_if(guests_, [&](const Guest& each) { return each.secret == secret; });
    int place = 1;
    while (std::ranges::any_of(seats_,
                               [&](const Seat& each) { return each.session.place == place; })) {
        ++place;
    }
    seats_.push_back({{++last_number_, place}, secret});
    wake_();
    return look(seats_.back());
}

bool Classroom::has_port(int port) {
    const std::lock_guard lock(mutex_);
    return std::ranges::any_of(seats_, [&](const Seat& each) { return each.port == port; });
}

void Classroom::lost() {
    is_lost_ = true;
    wake_();
}

std::vector<WantedSession> Classroom::take_wanted() {
    const std::lock_guard lock(mutex_);
    std::vector<WantedSession> wanted;
    for (Seat& seat : seats_) {
        if (std::exchange(seat.is_wanted, false)) {
            wanted.push_back(seat.session);
        }
    }
    return wanted;
}

void Classroom::started(int number, pid_t pid) {
    const std::lock_guard lock(mutex_);
    for (Seat& seat : seats_) {
        seat.pid = seat.session.number == number ? pid : seat.pid;
    }
}

void Classroom::ended(int number, const std::string& why) {
    const std::lock_guard lock(mutex_);
    const auto seat = std::ranges::find_if(
        seats_, [&](const Seat& each) { return each.session.number == number; });
    if (seat == seats_.end()) {
        return;
    }
    welcome({seat->secret, why});
    seats_.erase(seat);
}

int Classroom::taken() const {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(seats_.size());
}

}  // namespace pxpl5::host::serve

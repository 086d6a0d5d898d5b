#include <doctest/doctest.h>
#include <fmt/core.h>

#include <algorithm>

#include "host/serve/server/server_access.hpp"

namespace pxpl5::host::serve {
namespace {

AccessRules rules() {
    return {"d0d0", "eeee", "dddd", "5e5e", "pxpl5_8080", reachable_names("127.0.0.1"), false};
}

Request with_token(const std::string& token) {
    return {"GET", "/", {{"token", token}}, "127.0.0.1:8080", "", ""};
}

}  // namespace

TEST_CASE("a token makes a driver or a watcher, and gets a cookie that does the same") {
    const Verdict driver = judge(rules(), with_token("d0d0"));
    CHECK(driver.status == 200);
    CHECK(driver.role == Role::driver);
    CHECK(driver.cookie == "pxpl5_8080=dddd; HttpOnly; SameSite=Strict");
    const Verdict watcher = judge(rules(), with_token("eeee"));
    CHECK(watcher.status == 200);
    CHECK(watcher.role == Role::watcher);
    Request later{"GET", "/main.js", {}, "localhost:9000", "", "a=1; pxpl5_8080=dddd; b=2"};
    CHECK(judge(rules(), later).status == 200);
    CHECK(judge(rules(), later).role == Role::driver);
    CHECK(judge(rules(), later).cookie.empty());
    later.cookie = "pxpl5_8080=5e5e";
    CHECK(judge(rules(), later).role == Role::watcher);
}

TEST_CASE("the cookie, which other ports of this computer may see, is enough for the page alone") {
    Request request{"GET", "/socket", {}, "localhost:8080", "", "pxpl5_8080=dddd"};
    CHECK(judge(rules(), request).status == 200);
    CHECK(judge_by_token(rules(), request).status == 403);
    request.query = {{"token", "d0d0"}};
    CHECK(judge_by_token(rules(), request).status == 200);
    CHECK(judge_by_token(rules(), request).role == Role::driver);
    request.query = {{"token", "wrong"}};
    CHECK(judge_by_token(rules(), request).status == 403);
}

TEST_CASE("a cookie's value is no token, and a token is no cookie's value") {
    for (const char* session : {"dddd", "5e5e"}) {
        CHECK(judge(rules(), with_token(session)).status == 403);
    }
    for (const char* token : {"d0d0", "eeee"}) {
        const Request request{"GET", "/", {}, "localhost", "", fmt::format("pxpl5_8080={}", token)};
        CHECK(judge(rules(), request).status == 403);
    }
}

TEST_CASE("a refusal tells a stranger no name of this computer") {
    Request request = with_token("wrong");
    request.host = "evil.example";
    for (const std::string& name : rules().names) {
        CHECK(judge(rules(), request).reason.find(name) == std::string::npos);
    }
}

TEST_CASE("no token, a wrong one or another server's cookie is refused") {
    for (const char* token : {"", "d0d", "d0d00", "D0D0", "eeed"}) {
        CAPTURE(token);
        CHECK(judge(rules(), with_token(token)).status == 403);
    }
    for (const char* cookie : {"", "pxpl5_8080=", "pxpl5_8080=eeed", "pxpl5_80=dddd",
                               "xpxpl5_8080=dddd", "pxpl5_8080", "; ;=", "token=d0d0"}) {
        CAPTURE(cookie);
        CHECK(judge(rules(), {"GET", "/", {}, "localhost", "", cookie}).status == 403);
    }
    // A token that is wrong is not excused by a cookie that is right.
    Request both = with_token("wrong");
    both.cookie = "pxpl5_8080=dddd";
    CHECK(judge(rules(), both).status == 403);
}

TEST_CASE("the Host header names this computer, by whatever port a tunnel has") {
    Request request = with_token("d0d0");
    for (const char* host : {"localhost", "LOCALHOST:1", "127.0.0.1:5555", "[::1]:80", "[::1]"}) {
        CAPTURE(host);
        request.host = host;
        CHECK(judge(rules(), request).status == 200);
    }
    for (const char* host : {"evil.example", "evil.example:8080", "localhost.evil.example",
                             "127.0.0.1.evil.example:8080", "[::2]:80", "[::1", ":8080", "@"}) {
        CAPTURE(host);
        request.host = host;
        CHECK(judge(rules(), request).status == 403);
    }
    request.host = "";
    CHECK(judge(rules(), request).status == 400);
}

TEST_CASE("a page from elsewhere may not use the server") {
    Request request = with_token("d0d0");
    request.origin = "http://127.0.0.1:8080";
    CHECK(judge(rules(), request).status == 200);
    for (const char* origin : {"http://evil.example", "https://127.0.0.1:8080", "null",
                               "http://127.0.0.1:8081", "http://127.0.0.1:80800"}) {
        CAPTURE(origin);
        request.origin = origin;
        CHECK(judge(rules(), request).status == 403);
    }
    AccessRules encrypted = rules();
    encrypted.encrypted = true;
    request.origin = "https://127.0.0.1:8080";
    CHECK(judge(encrypted, request).status == 200);
    CHECK(judge(encrypted, request).cookie.ends_with("; Secure"));
}

TEST_CASE("browsers leave out the port of the scheme in the origin of a portal") {
    AccessRules behind = rules();
    allow_hosts(behind, {"full.example:443", "bare.example:80", "odd.example:8443"});
    Request request = with_token("d0d0");
    for (const char* origin :
         {"https://full.example", "http://full.example:443", "http://bare.example",
          "https://bare.example:80", "https://odd.example:8443", "http://odd.example:8443"}) {
        CAPTURE(origin);
        request.origin = origin;
        CHECK(judge(behind, request).status == 200);
    }
    for (const char* origin : {"http://full.example", "https://bare.example", "https://odd.example",
                               "https://odd.example:443"}) {
        CAPTURE(origin);
        request.origin = origin;
        CHECK(judge(behind, request).status == 403);
    }
}

TEST_CASE("tokens are 32 hexadecimal digits and never the same") {
    const std::string token = random_token();
    CHECK(token.size() == 32);
    CHECK(token.find_first_not_of("0123456789abcdef") == std::string::npos);
    CHECK(random_token() != token);
}

TEST_CASE("a server is reached by the loopback's names and by where it is bound") {
    const auto has = [](const std::vector<std::string>& names, const std::string& name) {
        return std::ranges::find(names, name) != names.end();
    };
    CHECK(has(reachable_names("127.0.0.1"), "localhost"));
    CHECK(has(reachable_names("127.0.0.5"), "127.0.0.5"));
    CHECK(has(reachable_names("192.0.2.7"), "192.0.2.7"));
    CHECK_FALSE(has(reachable_names("127.0.0.1"), ""));
    CHECK(is_loopback("127.1.2.3"));
    CHECK(is_loopback("::1"));
    for (const char* address : {"0.0.0.0", "::", "192.0.2.7", "128.0.0.1", "localhost", ""}) {
        CAPTURE(address);
        CHECK_FALSE(is_loopback(address));
    }
}

}  // namespace pxpl5::host::serve

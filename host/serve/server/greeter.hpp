// The web server of a class: it sends each student's browser to the student's own session.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

/// The answer to a student: a page with one heading and one sentence, or another port.
struct Greeting {
    int status = 200;  ///< Of HTTP.
    std::string heading, sentence;
    int again_s = 0;           ///< Seconds until the browser asks again; 0: never.
    int port = 0;              ///< Not 0: the browser is sent to this port of the computer.
    std::string token;         ///< The driver's, of the server at that port.
    std::string secret = {};   ///< Not empty: the student's cookie from now on.
};

/// What the greeter asks. Both functions are called in the server's thread.
struct Greeted {
    /// For a browser that has shown this cookie. Compares it in constant time with the secrets that
    /// were given out; an answer of status 0 says that it is none of them.
    std::function<Greeting(const std::function<bool(const std::string& secret)>& has_shown)> known;
    /// For a browser without a cookie that has shown the token of the class.
    std::function<Greeting()> fresh;
};

/// Serves from a thread of its own. Like Server, it asks every request for a secret and for a name
/// of this computer in Host, and keeps connections few that have not shown a secret.
class Greeter {
  public:
    /// options  Folders are not used. Throws as Server does.
    Greeter(const ServerOptions& options, Greeted greeted);
    ~Greeter();
    Greeter(const Greeter&) = delete;
    Greeter& operator=(const Greeter&) = delete;

    std::string url() const;  ///< For students, token included.
    int port() const;

  private:
    class Core;
    std::unique_ptr<Core> core_;
};

/// The path and query of an address of another port of this computer, seen from a page of the
/// greeter: "../4712/?token=T". A portal finds the port in it; without a portal, the greeter gets
/// this path, and sends the browser on to the other port.
std::string place_of(int port, std::string_view token);

/// The other port in such a path; 0 if there is none. "/rnode/n1/4712/" has none without a token.
int port_in(std::string_view path);

}  // namespace pxpl5::host::serve

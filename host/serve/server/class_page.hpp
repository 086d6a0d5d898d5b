// The web server of a class: it sends each browser to a session of its own.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "host/serve/server/server.hpp"
#include "host/serve/texts/texts.hpp"

namespace pxpl5::host::serve {

/// The answer to a browser: a page with a heading and a sentence, or the port of a session.
struct PageAnswer {
    int status = 200;  ///< HTTP status.
    Text heading, sentence;
    int again_s = 0;          ///< Seconds until the browser asks again; 0: never.
    std::string secret = {};  ///< Not empty: from now on the browser's cookie.
    int port = 0;             ///< Not 0: the browser is sent to this port of the computer.
    std::string token = {};   ///< The driver's token of the server there.
    std::string why = {};     ///< A sentence of the machine in English, before the other.
};

/// The page's questions. All are called in the thread of the page.
class ClassAnswers {
  public:
    virtual ~ClassAnswers() = default;
    /// Greets a browser that has shown a secret that was given out. Returns status 0 if it has
    /// shown none.
    ///
    /// has_shown  Whether the browser has shown this secret.
    virtual PageAnswer answer_known(
        const std::function<bool(const std::string& secret)>& has_shown) = 0;
    /// Greets a browser that has shown the token of the class.
    virtual PageAnswer answer_new() = 0;
    /// Returns whether a session has this port.
    virtual bool has_port(int port) = 0;
    /// The page cannot go on.
    virtual void fail() = 0;
};

/// Serves from a thread of its own. Every request needs a name of this computer in Host, and a
/// secret: the cookie or the token of the class. Connections without a secret are few and short, as
/// those of Server.
class ClassPage {
  public:
    /// options  Page and folders are not used.
    /// Throws as Server does.
    ClassPage(const ServerOptions& options, ClassAnswers& answers);
    ~ClassPage();
    ClassPage(const ClassPage&) = delete;
    ClassPage& operator=(const ClassPage&) = delete;

    std::string url() const;  ///< With the token of the class.
    int port() const;

  private:
    class Core;
    std::unique_ptr<Core> core_;
};

/// The port that ends a path such as "/rnode/n1/4712/"; 0 if there is none.
int last_port_in(std::string_view path);

/// A page of HTML. All texts are plain.
///
/// language  As language_of() returns it.
std::string page_text(const PageAnswer& answer, std::string_view language);

}  // namespace pxpl5::host::serve

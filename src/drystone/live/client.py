"""A client of the JSON interface in one file: for the Python of a CAD program, 2.7 or 3.

Copy it with ``drystone live --client drystone_client.py``, or from the package. It needs nothing
but the standard library::

    import drystone_client
    server = drystone_client.Server("http://127.0.0.1:8377/?token=...")  # what the server printed
    answer = server.check({"file": "vault.obj", "supports": "lowest", "friction": 0.6})
    print(answer["verdict"], answer["falling"])
"""

import json

try:  # Python 3
    from urllib.error import HTTPError, URLError
    from urllib.parse import parse_qs, urlsplit
    from urllib.request import ProxyHandler, Request, build_opener
except ImportError:  # Python 2.7, IronPython
    from urllib2 import HTTPError, ProxyHandler, Request, URLError, build_opener
    from urlparse import parse_qs, urlsplit

VERSION = "v1"


class Refused(Exception):
    """The server did not answer the question; the text says why, and what to do."""


class Server(object):  # noqa: UP004  # Python 2 needs it
    """A server that runs.

    link: what ``drystone live`` printed, with the token in it.
    seconds: how long to wait for an answer; a longer call is refused.
    """

    def __init__(self, link, seconds=120.0):
        parts = urlsplit(link)
        self._address = "http://%s/%s/" % (parts.netloc, VERSION)  # noqa: UP031
        self._token = parse_qs(parts.query).get("token", [""])[0]
        self._seconds = seconds
        self._opener = build_opener(ProxyHandler({}))

    def check(self, model):
        """Does it stand? Keys of the answer: verdict, message, falling, gives_way and more."""
        return self.call("check", model=model)

    def limit(self, model, of, axis="x", load=None):
        """How far? ``of`` is tilt, friction, load or shrink. Keys: stands, falls."""
        more = {} if load is None else {"load": load}
        return self.call("limit", model=model, of=of, axis=axis, **more)

    def plan(self, model, **rules):
        """In which order? Rules: hands, order, anyway. Keys: order, props, counts."""
        return self.call("plan", model=model, **rules)

    def mend(self, model, **how):
        """What makes it stand? how: kinds, keep. Keys: mends, tried."""
        return self.call("mend", model=model, **how)

    def call(self, name, **body):
        """The answer to any call, as a dict; ``Refused`` where there is none."""
        request = Request(self._address + name, json.dumps(body).encode("utf-8"))
        request.add_header("Authorization", "Bearer " + self._token)
        request.add_header("Content-Type", "application/json")
        try:
            answer = self._opener.open(request, timeout=self._seconds)
            return json.loads(answer.read().decode("utf-8"))
        except HTTPError as error:
            text = error.read().decode("utf-8")
            error.close()  # Python 3.14 warns of what is left open
            raise Refused(_in_words(text))  # noqa: B904  # Python 2
        except TimeoutError:
            raise Refused("no answer within %g s" % self._seconds)  # noqa: B904, UP031
        except URLError as error:
            raise Refused(  # noqa: B904
                "no server answers at %s: %s; start 'drystone live'"  # noqa: UP031
                % (self._address, error.reason)
            )


def _in_words(text):
    try:
        error = json.loads(text)["error"]
    except (ValueError, KeyError):
        return text[:200]
    words = [error.get("where"), error.get("what")]
    told = ": ".join(word for word in words if word)
    return "; ".join(word for word in (told, error.get("remedy")) if word)


def block(name, vertices, faces, fixed=False):
    """A block for the ``content`` of a model: points in metres, faces as lists of their numbers."""
    points = [[float(x) for x in point] for point in vertices]
    return {"name": name, "vertices": points, "faces": [list(f) for f in faces], "fixed": fixed}

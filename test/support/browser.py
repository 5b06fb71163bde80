"""Debian's Chromium, for pages that move."""
import contextlib
import json
import re
import subprocess
import urllib.request


@contextlib.contextmanager
def browser():
    """call(method, path, **body) of a headless Chromium, by the WebDriver protocol."""
    with subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, universal_newlines=True) as driver:
        try:
            port = next(found.group(1) for found in (re.search(r"successfully on port (\d+)", line) for line in driver.stdout) if found)

            def call(method, path, **body):
                request = urllib.request.Request(f"http://127.0.0.1:{port}/session{path}", method=method,
                                                 data=json.dumps(body).encode() if method == "POST" else None)
                with urllib.request.urlopen(request, timeout=120) as answer:
                    return json.load(answer)["value"]

            options = {"args": ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--window-size=900,800"]}
            session = "/" + call("POST", "", capabilities={"alwaysMatch": {"goog:chromeOptions": options}})["sessionId"]
            try:
                yield lambda method, path, **body: call(method, session + path, **body)
            finally:
                call("DELETE", session)
        finally:
            driver.terminate()

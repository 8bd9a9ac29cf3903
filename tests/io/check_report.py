"""Checks that a report page is self-contained and complete. usage: check_report.py FILE CAPTIONS [TEXT ...]"""
import base64
import re
import sys
from html.parser import HTMLParser


class Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.sources, self.open, self.text, self.captions, self.scripts = [], [], "", 0, 0

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        assert tag not in ("link", "iframe"), tag
        self.scripts += tag == "script" and "type" not in attributes
        if tag == "a":  # an index links to the reports beside it
            assert "//" not in attributes["href"], attributes["href"]
            attributes = {}
        for key in ("src", "href"):
            if key in attributes:
                self.sources.append(attributes[key])
        self.captions += tag == "figcaption"
        if tag not in ("img", "meta", "br", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        self.text += data


with open(sys.argv[1], encoding="utf-8") as f:
    source = f.read()
page = Page()
page.feed(source)
page.close()
assert not page.open, page.open
assert page.captions == int(sys.argv[2]), page.captions
assert "url(" not in source and "@import" not in source
assert not re.search(r"fetch\(|XMLHttpRequest|WebSocket|https?://", source), "something from elsewhere"
assert page.scripts >= 1, "no plot can be zoomed"
for uri in page.sources:
    kind, data = uri.split(",", 1)
    assert kind in ("data:image/png;base64", "data:image/svg+xml;base64"), kind
    raw = base64.b64decode(data, validate=True)
    assert raw.startswith(b"\x89PNG") or b"<svg" in raw
for text in sys.argv[3:]:
    assert text in page.text, text

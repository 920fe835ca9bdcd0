"""Who may ask: the token once, the cookie after it, this host, this page, and nothing that is malformed."""

import json
import random
import re
from urllib.parse import quote

import pytest
from starlette.routing import Route

ADDRESSES = ["/", "/machine", "/machine/part", "/assets/studio.js", "/ready", "/nowhere", "/..%2f..%2fetc/x"]


@pytest.mark.parametrize("address", ADDRESSES)
@pytest.mark.parametrize("name", [None, "cabledrive_5999", "cabledrive_6000"])
def test_without_the_right_cookie_nothing_is_told(studio, address, name):
    value = studio.keys.cookie if name == "cabledrive_6000" else "guess"
    answer = studio.get(address, key=False, headers={"cookie": f"{name}={value}"} if name else {})
    assert answer.status_code == 403
    assert "cabledrive_" not in answer.text


def test_the_token_is_exchanged_once_for_a_strict_cookie_and_leaves_the_address(studio):
    token = studio.keys.token
    first = studio.get(f"/?token={token}", key=False)
    assert (first.status_code, first.headers["location"]) == (303, "/")
    cookie = first.headers["set-cookie"]
    assert cookie.startswith("cabledrive_5999=")
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie.split("; "))
    assert studio.get(f"/?token={token}", key=False).status_code == 403
    given = {"cookie": cookie.split(";")[0]}
    assert studio.get("/machine", key=False, headers=given).status_code == 200
    assert studio.get(f"/?token={token}", key=False, headers=given).headers["location"] == "/"


def test_a_refused_request_does_not_use_the_token_up(studio):
    token = studio.keys.token
    for headers in ({"host": "evil.example"}, {"origin": "http://evil.example"}):
        assert studio.get(f"/?token={token}", key=False, headers=headers).status_code == 403
    assert studio.get("/?token=wrong", key=False).status_code == 403
    assert studio.get(f"/machine?token={token}", key=False).status_code == 403
    assert studio.ask("HEAD", f"/?token={token}", key=False).status_code == 403
    assert studio.get(f"/?token={token}", key=False).status_code == 303


def test_a_foreign_host_or_origin_is_refused_on_every_route(studio):
    checked = 0
    for route in (route for route in studio.app._app.routes if isinstance(route, Route)):
        address = re.sub(r"\{\w+\}", "1", route.path)
        for method in sorted(route.methods or ()):
            for headers in (
                {"host": "evil.example:5999"},
                {"host": "127.0.0.1"},
                {"origin": "http://evil.example"},
                {"origin": "null"},
                {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors"},
            ):
                answer = studio.ask(method, address, headers=headers)
                assert answer.status_code == 403, (method, address, headers)
                checked += 1
    assert checked >= 120


def test_a_change_must_say_which_page_it_comes_from(studio):
    headers = {"cookie": f"{studio.keys.cookie_name}={studio.keys.cookie}"}

    async def _post():
        async with studio.client() as client:
            return await client.post("/machine/text", content="x", headers=headers)

    assert studio.run(_post()).status_code == 403


def test_every_page_allows_itself_only_its_own_scripts(studio):
    pages = [studio.get("/machine"), studio.get("/machine")]
    policies = [page.headers["content-security-policy"] for page in pages]
    assert policies[0] != policies[1]  # a nonce is used once
    for page, policy in zip(pages, policies, strict=True):
        rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
        assert rules["default-src"] == "'none'"
        assert rules["frame-ancestors"] == "'none'"
        nonce = rules["script-src"].removeprefix("'nonce-").removesuffix("'")
        assert "unsafe" not in rules["script-src"] + rules["style-src"]
        assert page.text.count("<script") == page.text.count(f'nonce="{nonce}"') - page.text.count(
            '<link rel="stylesheet"'
        )
        assert " onclick=" not in page.text
    assert studio.get("/ready").headers["x-content-type-options"] == "nosniff"


EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\"'&"


def test_names_are_escaped_wherever_they_are_shown(studio):
    text = (
        studio.library.text("dissertation-3")
        .replace('title = "', f"title = {json.dumps(EVIL)} # was ")
        .replace('name = "dissertation-3"', f"name = {json.dumps(EVIL)}")
    )
    assert "<img" in text
    sent = studio.post("/machine/text", content=text.encode())
    assert sent.status_code == 200, sent.text
    query = sent.json()["query"]
    page, part = studio.get(f"/machine?{query}"), studio.get(f"/machine/part?{query}")
    for shown in (page.text, part.json()["part"]):
        assert "<img src=x" not in shown
        assert "<script>alert" not in shown
    assert "alert(1)" in page.text  # it is shown, as text
    shown = studio.get(f"/machine?drive={quote(EVIL)}&set={quote(EVIL)}").text
    assert "<img src=x" not in shown
    assert "<script>alert" not in shown


@pytest.mark.parametrize(
    "drive",
    ["../../../etc/passwd", "/etc/passwd", "..%2f..%2fsecret", "dissertation-3.toml", "x" * 500, "a\0b", ""],
)
def test_a_page_names_no_path(studio, drive):
    answer = studio.get("/machine/part", params={"drive": drive})
    assert answer.status_code == 200
    assert "is no drive of this studio" in answer.json()["refusal"]


def test_a_link_among_the_kept_drives_is_not_followed(studio, tmp_path):
    secret = tmp_path / "secret.toml"
    secret.write_text("schema = 1")
    kept = studio.library.part("drives") / "evil-0123456789ab.toml"
    kept.symlink_to(secret)
    assert "is no drive" in studio.get("/machine/part?drive=evil-0123456789ab").json()["refusal"]


def test_a_text_that_is_too_long_is_refused_before_it_is_read_whole(studio):
    async def _endless():
        for _ in range(100):
            yield b"#" * 100_000

    answer = studio.post("/machine/text", content=_endless())
    assert answer.status_code == 400
    assert "send less" in answer.text


def test_a_thousand_malformed_requests_are_answered_and_the_studio_lives(studio):
    """Paths, queries, cookies, headers and bodies drawn at random; no answer but 2xx, 3xx and 4xx."""
    draw = random.Random(0)
    pieces = ["A" * 3000, "%00", "%ff%fe", "%", "..", "/", "\\", "?", "&set=", "&drive=", "=", "<script>"]
    pieces += ["é", "𝄞", "drive=dissertation-3", "row=-1", "count=1e9", "motor=x"]
    pieces += ["set=cable.pretension=", "set=pulley.9.radius=1"]
    paths = ["/", "/machine", "/machine/part", "/machine/text", "/assets/", "/ready", "/jobs/", "/logs/"]
    key = {"cookie": f"{studio.keys.cookie_name}={studio.keys.cookie}"}

    async def _all():
        answers = []
        async with studio.client(headers=key) as client:
            for _ in range(1000):
                path = draw.choice(paths)
                query = "".join(draw.choice(pieces) for _ in range(draw.randrange(6)))
                body = bytes(draw.randrange(256) for _ in range(draw.randrange(40)))
                method = draw.choice(["GET", "POST", "PUT", "DELETE", "OPTIONS", "TRACE", "BREW"])
                try:
                    answer = await client.request(
                        method,
                        path + draw.choice(["", "x", "%2e%2e"]) + "?" + quote(query, safe="%&=?/\\"),
                        content=body,
                        headers={"origin": "http://127.0.0.1:5999"},
                    )
                except ValueError:
                    continue  # not even a request
                answers.append(answer.status_code)
        return answers

    answers = studio.run(_all())
    assert len(answers) > 900
    assert set(answers) <= {200, 303, 400, 403, 404, 405, 422}, set(answers)
    assert studio.get("/machine/part?drive=dissertation-3").json()["frequencies"]

"""The replay page: what it holds, that it needs no network, and, in a browser, what clicks do."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from needs import need
from numpy.typing import NDArray
from report.browser import Browser, find
from report.checked import HOSTILE, crash, near, tools

from gcodesim.collision.views.distances import distances
from gcodesim.machine.kinematics import world_from_link
from gcodesim.report import html
from gcodesim.report.html import page


def unpacked(text: str, dtype: str) -> NDArray[Any]:
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype)


def data_of(text: str) -> dict[str, Any]:
    (found,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text)
    value: dict[str, Any] = json.loads(found)
    return value


def test_the_page_holds_the_meshes_the_motion_and_the_text() -> None:
    result, replay = crash()
    data = data_of(page(result, replay))
    for shown, told in zip(replay.bodies(), data["bodies"], strict=True):
        assert told["name"] == shown.body.name
        for part, place in zip(shown.body.parts, told["parts"], strict=True):
            mesh = data["meshes"][place["mesh"]]
            vertices = unpacked(mesh["vertices"], "<f4").reshape(-1, 3)
            faces = unpacked(mesh["faces"], "<u4").reshape(-1, 3)
            assert np.array_equal(vertices[faces], part.triangles.astype(np.float32))
            assert len(np.unique(vertices, axis=0)) == len(vertices)
    times = unpacked(data["knots"]["time"], "<f8")
    positions = unpacked(data["knots"]["positions"], "<f8").reshape(len(times), -1)
    true = replay.path.positions(np.rint(times * 1e12).astype(np.int64))
    np.testing.assert_allclose(positions, true, atol=1e-6)
    text = zlib.decompress(base64.b64decode(data["program"]["text"])).decode()
    assert text.split("\n") == list(replay.lines)
    assert data["report"]["verdict"] == "fail"


def test_a_page_needs_no_network_and_runs_nothing_of_the_program() -> None:
    result, replay = crash()
    text = page(result, replay)
    assert "content=\"default-src 'none'; script-src 'unsafe-inline' data:" in text
    assert not re.findall(r"(?:src|href)=|@import|url\(", text)
    assert text.count("</script>") == text.count("<script") == 3
    assert len(text) < 2_000_000


def test_equal_meshes_are_carried_once() -> None:
    result, replay = tools()
    data = data_of(page(result, replay))
    places = [part["mesh"] for body in data["bodies"] for part in body["parts"]]
    assert sorted(set(places)) == list(range(len(data["meshes"])))
    assert [body["spans"] is None for body in data["bodies"]][-2:] == [False, False]


def test_a_text_that_is_too_long_is_left_out_and_that_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(html, "MOST_LINES", 5)
    data = data_of(page(*crash()))
    assert data["program"] is None
    assert "the program's text is left out: more than 5 lines" in data["note"]


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests."""
    program = find()
    need(program, "chromium-headless-shell")
    with Browser(program) as opened:
        checks = {"crash": crash(), "tools": tools(), "near": near()}
        for name, (result, replay) in checks.items():
            file = tmp_path_factory.mktemp("pages") / f"{name}.html"
            file.write_text(page(result, replay), encoding="utf-8")
            opened.pages[name] = file
        yield opened
        assert not opened.errors


def stands(browser: Browser, link: str) -> NDArray[np.float64]:
    """Pose of a link in the page, (4, 4)."""
    rows = browser.value(
        f"(viewer.scene.scene.updateMatrixWorld(true),"
        f" viewer.scene.links.find((l) => l.name === '{link}').matrixWorld.toArray())"
    )
    return np.array(rows).reshape(4, 4).T


def assert_posed(browser: Browser, replay: Any) -> None:
    """Every link stands where the kinematics put it at the page's time."""
    time_ps = round(browser.value("viewer.time") * 1e12)
    q = replay.path.positions(np.array([time_ps]))[0]
    for link, pose in world_from_link(replay.machine, q).items():
        # 0.01 mm and deg, at 500 mm from the axis 0.09 mm
        np.testing.assert_allclose(stands(browser, link), pose, atol=0.1, err_msg=link)


def test_the_page_opens_at_the_first_contact(browser: Browser) -> None:
    result, replay = crash()
    browser.open(browser.pages["crash"])
    assert browser.value("document.title") == "tilt.nc on table_tilt: fail"
    assert browser.value("document.getElementById('verdict').textContent") == "fail"
    assert browser.value("viewer.time") == result.first_contact.time_s
    assert browser.value("viewer.scene.mark.position.toArray()") == pytest.approx(
        result.first_contact.point_mm
    )
    current = "document.querySelector('#rows .current')"
    assert browser.value(f"{current}.textContent") == "N130 A-40. F2000."
    assert browser.value(f"{current}.dataset.number") == "17"
    # The hostile comment stands in the list as it was written.
    browser.value("document.getElementById('program').scrollTop = 0")
    rows = "document.getElementById('rows').textContent"
    browser.wait(f"{rows}.includes({json.dumps(HOSTILE)})")
    assert_posed(browser, replay)


def test_findings_distances_and_the_timeline_are_clicked(browser: Browser) -> None:
    _, replay = crash()
    browser.open(browser.pages["crash"])
    browser.click("#time", 0.25)
    assert 0.2 < browser.value("viewer.time / viewer.data.duration") < 0.3
    assert browser.value("viewer.scene.mark.visible") is False
    assert_posed(browser, replay)
    browser.click("#findings li.error")
    assert browser.value("viewer.time") == pytest.approx(2.009)
    assert browser.value("viewer.scene.mark.visible") is True
    row = "#distances li:last-child"
    told = browser.value(f"document.querySelector('{row}').textContent")
    browser.click(row)
    assert f"{browser.value('viewer.time'):.3f} s" in told
    browser.click("#marks b.error")
    assert browser.value("viewer.time") == pytest.approx(2.009)
    browser.click("#rows [data-line='13']")  # N90 G43 H1 Z150.
    assert browser.value("document.querySelector('#rows .current').dataset.number") == "13"


def told_of(browser: Browser) -> dict[str, str]:
    """Pair -> what its row tells."""
    rows = browser.value("Array.from(document.querySelectorAll('#now li'), (row) => row.innerText)")
    return dict(row.split("\n") for row in rows)


def test_distances_follow_the_timeline_and_a_row_jumps_to_the_nearest(browser: Browser) -> None:
    result, replay = crash()
    browser.open(browser.pages["crash"])
    times = np.array(browser.value("Array.from(viewer.distances.time)"))
    assert {0.0, result.first_contact.time_s, result.duration_s} <= set(times.tolist())
    found = distances(replay.machine, replay.path, "cpu", np.rint(times * 1e12).astype(np.int64))
    assert np.array_equal(found.time_ps / 1e12, times)
    distance = found.distance
    names = [pair.name.replace("-", " - ") for pair in replay.machine.pairs]
    for share in (0.2, 0.4):
        browser.click("#time", share)
        frame = int(np.searchsorted(times, browser.value("viewer.time"), side="right")) - 1
        told = told_of(browser)
        assert [told[name] for name in names] == [f"{mm:.3f} mm" for mm in distance[frame]]
        nearest = browser.value("document.querySelector('#now .smallest span').textContent")
        assert nearest == names[int(distance[frame].argmin())]
        assert browser.value("document.getElementById('frame').textContent") == (
            f"at {times[frame]:.3f} s"
        )
        # Between frames the numbers are those of the earlier one, and nothing is drawn.
        assert browser.value("viewer.scene.line.visible") is False
        browser.click("#frame")
        assert browser.value("viewer.time") == times[frame]
        ends = "Array.from(viewer.scene.line.children[0].geometry.attributes.position.array)"
        a, b = np.array(browser.value(ends)).reshape(2, 3)
        assert browser.value("viewer.scene.line.visible") is True
        assert np.linalg.norm(a - b) == pytest.approx(distance[frame].min(), abs=1e-3)
    browser.click("#now li")  # the pair in contact
    frame = int(distance[:, names.index("cutter - A")].argmin())
    assert browser.value("viewer.time") == times[frame]
    assert times[frame] == pytest.approx(result.first_contact.time_s, abs=result.sample_period_s)
    assert told_of(browser)["cutter - A"] == "touches"
    assert browser.value("viewer.scene.bodies.filter((b) => b.group.children[0].material.color"
                         ".getHex() === 0xd6322c).map((b) => b.name)") == ["cutter"]  # fmt: skip


ON_SCREEN = """(() => {
  const { bodies, camera, mark } = viewer.scene, seen = [];
  const meshes = bodies.flatMap(({ group }) => group.children.filter((child) => child.isMesh));
  for (const mesh of meshes) {
    const { position } = mesh.geometry.attributes, vertex = mark.position.clone();
    for (let i = 0; i < position.count; i++) {
      vertex.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld).project(camera);
      seen.push(Math.max(Math.abs(vertex.x), Math.abs(vertex.y)));
    }
  }
  return seen.reduce((most, share) => Math.max(most, share), 0);
})()"""
"""How far from the middle any vertex of the machine is seen, at most; 1: at the edge."""


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1000, 700), (600, 900)])
def test_fit_shows_the_whole_machine(browser: Browser, width: int, height: int) -> None:
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.ask("Emulation.setDeviceMetricsOverride", **size)
    try:
        browser.open(browser.pages["near"])
        for camera in ("whole", "front", "side", "top"):
            browser.click(f"[data-camera={camera}]")
            browser.wait("!viewer.scene.dirty")
            assert 0.3 < browser.value(ON_SCREEN) < 1.0
    finally:
        browser.ask("Emulation.clearDeviceMetricsOverride")


def test_only_a_pair_that_touches_or_is_nearer_than_its_clearance_alarms(browser: Browser) -> None:
    """cutter and C come to 3.21 mm where 7 mm are asked for; at the start all are far apart."""
    browser.open(browser.pages["near"])
    alarms = "Array.from(document.querySelectorAll('#now .alarm span'), (e) => e.textContent)"
    assert browser.value("document.querySelectorAll('#now .smallest').length") == 1
    assert browser.value(alarms) == []
    browser.click("#findings li.warning")
    assert browser.value(alarms) == ["cutter - C"]


def test_play_runs_to_the_end_and_stops(browser: Browser) -> None:
    browser.open(browser.pages["tools"])
    assert browser.value("viewer.time") == 0
    browser.value("document.getElementById('speed').value = '100'")
    browser.click("#play")
    browser.wait("viewer.time === viewer.data.duration && !viewer.playing")
    assert browser.value("document.getElementById('play').textContent") == "play"
    assert_posed(browser, tools()[1])
    browser.value("document.getElementById('speed').value = '0.1'")
    browser.click("#play")  # begins again
    browser.wait("viewer.playing && 0 < viewer.time && viewer.time < viewer.data.duration / 2")
    browser.click("#play")
    assert browser.value("viewer.playing") is False


def test_bodies_are_ghosted_and_hidden_and_tools_come_and_go(browser: Browser) -> None:
    browser.open(browser.pages["tools"])
    button = "#bodies button[data-body=C]"
    body = "viewer.scene.bodies.find((b) => b.name === 'C').group"
    for state, visible, opacity in (
        ("ghost", True, 0.15),
        ("hidden", False, 1),
        ("shown", True, 1),
    ):
        browser.click(button)
        assert browser.value(f"document.querySelector('{button}').textContent") == state
        assert browser.value(f"{body}.visible") is visible
        assert browser.value(f"{body}.children[0].material.opacity") == opacity
    there = "viewer.scene.bodies.slice(-2).map((b) => b.group.visible)"
    assert browser.value(there) == [True, False]
    browser.click("#time", 0.9)
    assert browser.value(there) == [False, True]


def test_the_camera_turns_and_the_machine_is_drawn(browser: Browser) -> None:
    browser.open(browser.pages["crash"])
    camera = "viewer.scene.camera.position.toArray()"
    before = browser.value(camera)
    for kind, x in (("mousePressed", 400.0), ("mouseMoved", 460.0), ("mouseReleased", 460.0)):
        browser.mouse(kind, x, 300.0)
    browser.wait(f"Math.hypot(...{camera}.map((v, i) => v - {before}[i])) > 10")
    browser.click("[data-camera=top]")
    top, target = browser.value(camera), browser.value("viewer.scene.controls.target.toArray()")
    assert top[2] - target[2] > 50 * np.hypot(top[0] - target[0], top[1] - target[1])
    browser.click("[data-camera=near]")
    assert browser.value("viewer.scene.controls.target.toArray()") == pytest.approx(
        list(crash()[0].first_contact.point_mm)
    )
    browser.click("#focus")
    browser.wait("!viewer.scene.dirty")
    red, blue = browser.value(
        "(() => { viewer.scene.dirty = true; viewer.scene.draw();"
        " const gl = viewer.scene.renderer.getContext();"
        " const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];"
        " const dots = new Uint8Array(4 * w * h);"
        " gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, dots);"
        " const count = (i, j) => { let n = 0; for (let k = 0; k < dots.length; k += 4)"
        " if (dots[k + i] > 1.5 * dots[k + j]) n++; return n / (w * h); };"
        " return [count(0, 2), count(2, 0)]; })()"
    )
    assert red > 0.01
    assert blue > 0.05

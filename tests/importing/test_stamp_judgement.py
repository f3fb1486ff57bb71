"""Stamps are judged all together: one bad stamp costs one frame, a clock that was set costs the shorter part, a counter that wraps is named."""

import random
from collections import Counter

import pytest
from polhode_ground.importing.numbering import frame_numbers
from polhode_ground.importing.stamps import CLOCK_SET, NO_TIME, OUT_OF_LINE, REPEATS, find_gaps, judge

NS = 1_000_000_000
STEP = NS // 10
EPOCH = 1_700_000_000 * NS
COUNT = 90
GOOD = [EPOCH + i * STEP for i in range(COUNT)]
HOUR = 3600 * NS


def with_bad(stamps, bad: dict) -> list:
    return [bad.get(place, stamp) for place, stamp in enumerate(stamps)]


def kept(judgement) -> list[int]:
    return [place for place, time in enumerate(judgement.times_ns) if time is not None]


def set_clock(by_ns: int, at: int) -> list[int]:
    return [stamp + (by_ns if place >= at else 0) for place, stamp in enumerate(GOOD)]


# verifies: GND-03
@pytest.mark.parametrize("bad", [
    {40: 0}, {0: 0}, {89: 0}, {20: 2147483647 * NS}, {89: 2147483647 * NS}, {20: GOOD[25]}, {20: GOOD[20] + 13 * STEP // 10},
    {20: GOOD[20] - HOUR, 21: GOOD[21] - HOUR}, {20: 2147483647 * NS, 21: 0}, {i: i for i in range(5, 90, 10)}, {30: 2**64 - 1}])
def test_bad_stamps_cost_their_own_frames(bad):
    judgement = judge(with_bad(GOOD, bad))
    assert kept(judgement) == [place for place in range(COUNT) if place not in bad]
    assert Counter(judgement.reasons.values()) == {OUT_OF_LINE: len(bad)}
    assert [judgement.times_ns[place] for place in kept(judgement)] == [GOOD[place] for place in kept(judgement)]


def test_a_time_of_0_is_a_time_where_its_neighbours_are_near():
    judgement = judge([i * STEP for i in range(COUNT)], GOOD)
    assert judgement.times_ns[0] == 0 and len(kept(judgement)) == COUNT and judgement.assumed == []


@pytest.mark.parametrize("stamps", [[0] * COUNT, [7] * COUNT, [0] * 50 + GOOD[50:]])
def test_stamps_that_say_nothing_give_way_to_the_times_of_receipt(stamps):
    judgement = judge(stamps, GOOD)
    assert judgement.times_ns == GOOD and "the times are when the bag received the messages" in judgement.assumed[0]


@pytest.mark.parametrize("back_ns", [HOUR, NS, 3 * STEP])
def test_of_a_clock_that_was_set_back_the_longer_part_is_taken(back_ns):
    judgement = judge(set_clock(-back_ns, at=30))
    assert kept(judgement) == list(range(30, COUNT)) and set(judgement.reasons.values()) == {CLOCK_SET}
    assert f"set back by {back_ns / NS:g} s before picture 31" in judgement.assumed[0]


def test_a_recording_of_two_runs_is_no_recording_without_stamps():
    twice = GOOD[:45] * 2
    assert kept(judge(twice, GOOD)) == list(range(45)) and "set back by 4.5 s" in judge(twice, GOOD).assumed[0]


def test_a_clock_that_was_set_ahead_is_told_from_a_pause_by_the_times_of_receipt():
    ahead = set_clock(HOUR, at=60)
    assert kept(judge(ahead, GOOD)) == list(range(60))
    assert kept(judge(ahead)) == list(range(COUNT))
    assert "3600.1 s after picture 60 of the source (or a pause, or a clock that was set ahead)" in find_gaps(ahead, range(COUNT)).said


def test_a_clock_that_is_first_set_while_it_runs_is_set_ahead():
    judgement = judge([12 * NS + i * STEP if i < 10 else stamp for i, stamp in enumerate(GOOD)])
    assert kept(judgement) == list(range(10, COUNT)) and "set ahead by" in judgement.assumed[0]


# verifies: GND-03
@pytest.mark.parametrize("epoch_ns", [0, EPOCH])
@pytest.mark.parametrize(("bits", "tick_ns"), [(32, 1000), (32, 1), (24, 1000), (16, 1_000_000), (32, 8)])
def test_a_counter_that_wraps_is_unwrapped_and_named(bits, tick_ns, epoch_ns):
    period = 2**bits * tick_ns
    step = min(STEP, period // 200)
    true = [period - 45 * step + step // 3 + i * step for i in range(COUNT)]
    judgement = judge([epoch_ns + time % period for time in true])
    assert judgement.times_ns == [epoch_ns + time for time in true]
    assert f"begin again after picture 45 of the source, as a counter does after {period / NS:.9g} s" in judgement.wraps[0]


@pytest.mark.parametrize(("period_s", "first_s", "count"), [(128, 120, 3000), (86400, 86395, 90), (1, 0, 90)])
def test_times_of_day_and_cycle_timers_are_unwrapped(period_s, first_s, count):
    true = [first_s * NS + i * STEP for i in range(count)]
    judgement = judge([time % (period_s * NS) for time in true])
    assert judgement.times_ns == true and judgement.wraps


def test_a_counter_that_wraps_may_have_bad_stamps_and_lost_frames():
    period = 2**32 * 1000
    true = [period - 45 * NS + i * NS + 500_000 for i in range(COUNT) if i not in (44, 45, 46)]
    judgement = judge(with_bad([time % period for time in true], {20: 0, 60: 10**15}))
    assert len(kept(judgement)) == len(true) - 2 and all(judgement.times_ns[place] == true[place] for place in kept(judgement))


def test_lists_out_of_order_are_sorted_and_recordings_of_a_set_clock_are_not():
    shuffled, turned = random.Random(1).sample(GOOD, COUNT), GOOD[45:] + GOOD[:45]
    by_name = [GOOD[i] for i in sorted(range(COUNT), key=str)]
    for stamps in (shuffled, turned, by_name):
        judgement = judge(stamps)
        assert judgement.times_ns == stamps and "not in order of time: sorted" in judgement.assumed[0]
    assert not any("sorted" in one for one in judge(set_clock(-HOUR, at=45)).assumed)


# verifies: GND-03
@pytest.mark.parametrize("count", [3, 5, 9, 10, 12, COUNT])
def test_a_list_from_the_newest_to_the_oldest_is_reversed_without_a_loss(count):
    for stamps in (GOOD[:count][::-1], [*GOOD[count // 2:count][::-1], None, *GOOD[:count // 2][::-1]]):
        judgement = judge(stamps)
        assert judgement.times_ns == stamps and "runs from the newest to the oldest: reversed" in judgement.assumed[0]
        assert set(judgement.reasons.values()) <= {NO_TIME}


def test_repeats_missing_and_negative_times():
    judgement = judge(with_bad(GOOD, {7: None, 41: GOOD[40]}))
    assert judgement.reasons == {7: NO_TIME, 41: REPEATS}
    before = judge([i * STEP - 5 * STEP for i in range(COUNT)])
    assert before.times_ns == [i * STEP for i in range(COUNT)] and "shifted to begin at 0" in before.assumed[0]


@pytest.mark.parametrize("stamps", [[], [5], [3, 5], [5, 3], [None, None]])
def test_few_stamps_are_taken_as_they_are(stamps):
    assert judge(stamps).times_ns == stamps


def test_jitter_and_bursts_are_no_bad_stamps():
    jitter = [stamp + random.Random(place).randint(-30, 30) * 1_000_000 for place, stamp in enumerate(GOOD)]
    bursts = [EPOCH + i // 10 * NS + i % 10 * 1_000_000 for i in range(COUNT)]
    for stamps in (jitter, bursts):
        assert judge(stamps).times_ns == stamps
        assert kept(judge(with_bad(stamps, {33: 0}))) == [place for place in range(COUNT) if place != 33]
    assert "8 pauses" in find_gaps(bursts, range(COUNT)).said


def test_gaps_are_counted_in_frames_and_seconds():
    lost = [stamp for place, stamp in enumerate(GOOD) if not 30 <= place < 60 and place != 70]
    gaps = find_gaps(lost, range(len(lost)))
    assert (gaps.frames, gaps.count, gaps.after) == (31, 2, 29)
    assert gaps.said == "about 31 frames in 2 gaps, the longest of 3.1 s after picture 30 of the source"
    assert find_gaps(GOOD, range(COUNT)).said == ""
    # A frame that is left out for its stamp is told as that, not as missing.
    assert find_gaps(judge(with_bad(GOOD, {40: 0})).times_ns, range(COUNT)).frames == 0


@pytest.mark.parametrize(("names", "frames", "says"), [
    (["f_01.png", "f_02.png", "f_05.png"], [0, 1, 4], "jump from f_02.png to f_05.png: 2 pictures are missing"),
    (["10.png", "20.png", "30.png", "60.png"], [0, 1, 2, 5], "2 pictures are missing"),
    (["cam0_1.png", "cam0_2.png", "cam0_3.png"], [0, 1, 2], ""),
    (["a/1.png", "a/2.png", "a/5.png", "b/1.png", "b/2.png", "b/3.png"], [0, 1, 4, 5, 6, 7], "jump from a/2.png to a/5.png: 2 pictures"),
    (["p1_1.png", "p1_2.png", "p1_5.png", "p2_1.png", "p2_2.png", "p2_3.png"], [0, 1, 4, 5, 6, 7], "jump from p1_2.png to p1_5.png: 2 pictures"),
    (["1.png", "7.png", "9.png", "40.png"], [0, 1, 2, 3], "no count of frames"),
    (["x.png", "y.png", "z.png"], [0, 1, 2], ""),
    (["1.png", "1.jpg", "2.png", "3.png"], [0, 1, 2, 3], "no count of frames")])
def test_numbers_in_names_tell_gaps(names, frames, says):
    found, said = frame_numbers(names)
    assert found == frames and says in said and bool(says) == bool(said)

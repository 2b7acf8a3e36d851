import threading

from mossar_adapters.receiving.fair_queue import FairQueue


def all_of(queue):
    found = []
    while (message := queue.get(0)) is not None:
        found.append(message)
    return found


def test_messages_of_a_client_keep_their_order_and_clients_take_turns():
    queue = FairQueue(100)
    for k in range(4):
        queue.put("flood", ("flood", k))
    queue.put("good", ("good", 0))
    queue.put("good", ("good", 1))
    assert all_of(queue)[:4] == [("flood", 0), ("good", 0), ("flood", 1), ("good", 1)]


def test_a_flood_drops_its_own_oldest():
    queue = FairQueue(10)
    queue.put("good", "good")
    assert sum(queue.put("flood", k) for k in range(50)) == 41
    assert sorted(map(str, all_of(queue))) == sorted(["good", *map(str, range(41, 50))])


def test_the_only_message_of_a_client_is_kept():
    queue = FairQueue(3)
    assert [queue.put(client, client) for client in range(5)] == [0] * 5
    assert all_of(queue) == [0, 1, 2, 3, 4]


def test_one_that_waits_gets_what_comes():
    queue = FairQueue(3)
    timer = threading.Timer(0.05, lambda: queue.put("a", "late"))
    timer.start()
    assert queue.get(10.0) == "late"
    assert queue.get(0.01) is None

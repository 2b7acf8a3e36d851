"""People in pictures: webcams and videos as sensors, `webcam:` and `dance.mp4`."""

"""A live view of scenes, films and pictures in the browser: ``alight view``.

::

    protocol     what the browser asks for, checked          -> an event
    session      what is shown, and to whom                  <- events
    live         the render loop: restarts with the camera   -> a film that grows
    painter      a layer of it, developed for a display      -> frames
    server       the page, its address and who may open it

Data flows one way: events change the session, the render loop follows the session, the painter
follows the film, and the browser draws what it is sent.
"""

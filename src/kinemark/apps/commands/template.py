"""x"""
def template(): pass
